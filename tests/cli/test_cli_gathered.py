"""A command's options declared as the fields of a dataclass."""

from __future__ import annotations

from dataclasses import FrozenInstanceError, dataclass
from pathlib import Path
from typing import Annotated

import pytest
import typer
from typer.exceptions import TyperException

from sstl_cli.cli._gathered import gathered


@dataclass(frozen=True, kw_only=True)
class Shared:
    low: Annotated[float | None, typer.Option(min=0, help="A bound.")] = None
    high: Annotated[float, typer.Option(help="Another.")] = 2.0


@dataclass(frozen=True, kw_only=True)
class Asked:
    files: Annotated[list[Path], typer.Argument(metavar="FILE...")]
    bounds: Shared
    loud: Annotated[bool, typer.Option("--loud")] = False


@pytest.fixture
def call(capsys):
    seen = []
    app = typer.Typer()

    @app.command()
    @gathered
    def command(asked: Asked) -> None:
        """Do it."""
        seen.append(asked)

    own = typer.main.get_command(app)

    def run(*words):
        own(list(words), standalone_mode=False)
        return seen[-1]

    run.command = own
    return run


def test_fields_are_options_in_their_order_and_a_group_stands_in_its_place(call):
    names = [p.name for p in call.command.params]
    assert names[:4] == ["files", "low", "high", "loud"]
    assert call.command.help == "Do it."
    assert call("a", "b", "--low", "1") == Asked(files=[Path("a"), Path("b")], bounds=Shared(low=1.0))
    assert call("a", "--high", "3", "--loud") == Asked(files=[Path("a")], bounds=Shared(high=3.0), loud=True)


def test_what_was_asked_for_stays_as_it_was(call):
    with pytest.raises(FrozenInstanceError):
        call("a").loud = True


def test_a_required_field_is_a_required_argument(call):
    assert [p.required for p in call.command.params[:4]] == [True, False, False, False]
    with pytest.raises(TyperException):
        call("--loud")
