"""Controller parameters as a JSON document (schema sstl.controller/1): lines and options of each configuration."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import Field

from sstl_cli.control.controller import Controller, Options, Theta
from sstl_cli.core.config import Model, parse
from sstl_cli.core.errors import SstlError, nearest

SCHEMA = "sstl.controller/1"


class Lines(Model):
    """Propagation lines: slopes and biases (N)."""

    gamma_p: float
    beta_p: float
    gamma_r: float
    beta_r: float


class Entry(Model):
    """The lines of one configuration and where they come from."""

    config_id: str
    method: str = "DI"
    theta: Lines

    def lines(self) -> Theta:
        """Return the checked propagation lines."""
        t = self.theta
        return Theta(t.gamma_p, t.beta_p, t.gamma_r, t.beta_r)


class Document(Model):
    """Everything a controller needs, for one or more configurations."""

    schema_id: str = Field(SCHEMA, alias="schema", pattern=r"^sstl\.controller/1$")
    units: dict[str, str] = {"gamma": "1", "beta": "N", "tension": "N", "time": "s"}
    options: Options = Options()
    configurations: tuple[Entry, ...] = Field(min_length=1)

    def choose(self, config_id: str | None) -> Entry:
        """Return one configuration; the only one where none is named."""
        return self.configurations[index_of([c.config_id for c in self.configurations], config_id)]

    def plain(self) -> dict[str, Any]:
        """Return what JSON is written from."""
        return self.model_dump(by_alias=True, mode="json")


def index_of(config_ids: list[str], wanted: str | None) -> int:
    """Return the position of the wanted configuration, or of the only one.

    Raises
    ------
    SstlError
        If it is unknown, or there are several and none is named.
    """
    if wanted is None:
        if len(config_ids) == 1:
            return 0
        shown = ", ".join(config_ids[:8]) + (", ..." if len(config_ids) > 8 else "")
        raise SstlError(f"{len(config_ids)} configurations ({shown})", fix="choose one with --config-id", code="E406")
    if wanted not in config_ids:
        raise SstlError(f"no configuration '{wanted}' ({nearest(wanted, config_ids)})", code="E406")
    return config_ids.index(wanted)


def document(lines: Mapping[str, Theta], options: Options, method: str) -> Document:
    """Return the document for named configurations."""
    entries = tuple(
        Entry(config_id=name, method=method, theta=Lines(gamma_p=t.gamma_p, beta_p=t.beta_p, gamma_r=t.gamma_r, beta_r=t.beta_r))
        for name, t in lines.items()
    )
    return Document(schema=SCHEMA, options=options, configurations=entries)


def read(content: Any, where: str) -> Document:
    """Return a checked document; SstlError names the first thing that does not fit."""
    return parse(Document, content, where)


def controller_of(entry: Entry, options: Options) -> Controller:
    """Return the controller of one configuration."""
    return Controller(entry.lines(), options, entry.method != "none")
