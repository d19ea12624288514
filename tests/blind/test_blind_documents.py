"""What the blind check prints where it takes minutes to hours, made of small sets and of diagnoses that are stood in for."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from program import inside
from test_blind_folder import call, oracle
from test_blind_library import gathered, many, save
from test_blind_real import answering, recording
from told import checked

from sstl_cli.core import documents
from sstl_cli.core.documents.blind import CaseDistance
from sstl_cli.core.documents.diagnosis import DiagnosisDocument, Gap, Verdict
from sstl_cli.physics.scenario import Scenario
from sstl_cli.steps import blind_inject, blind_learn, blind_library, blind_limit, blind_real

# makes a set, a library and injections
pytestmark = pytest.mark.slow
SAMPLE = Path(__file__).parents[2] / "data/samples/log.parquet"


def distance(case: str, truth: Any, sim: object, exclude: object) -> CaseDistance:
    """Return a distance that nobody took, for whatever was withheld."""
    there = dict.fromkeys(("channel", "d2_base_known", "d2_rival_known", "d2_law", "d2_own", "why"))
    far = {"d2_base": 100.0, "d2_rival": 30.0, "rival": "slack", "rivals": {"slack": 30.0}}
    return CaseDistance(case=case, effects=sorted(truth.effects), decidable=True, decidable_known=True, **there, **far)


def of_a_set(folder: Path, patch: pytest.MonkeyPatch) -> list[dict]:
    """Return what run, limit and score print of a set whose results know the truth."""
    root = folder / "set"
    assert call("make", root, "--cases", 4, "--quick", "--seed", 900, "--workers", 1).exit_code == 0
    oracle(root)
    patch.setattr(blind_limit, "run", distance)
    return [json.loads(call(word, root, "--workers", 1, "--json").stdout) for word in ("run", "limit")] + [
        json.loads(call("score", root, "--json").stdout)
    ]


def of_a_library(folder: Path) -> list[dict]:
    """Return what library and learn say of hand-made rows."""
    made = blind_library.run(folder / "l.parquet", blind_library.Options(6, 10, "mixed", True), gatherer=gathered([]))
    _, learned = blind_learn.run([save(folder / "many.parquet", many(180))], "w.json")
    return [made.plain(), learned.plain()]


def of_a_rig(patch: pytest.MonkeyPatch) -> list[dict]:
    """Return what real says of terms taken out, and of effects put in."""
    verdict = Verdict(status="identified", effects=["zero_offset"], confidence=0.9, ambiguity_group=["zero_offset"], why="")
    said = DiagnosisDocument.model_construct(verdict=verdict, gap=Gap.model_construct(shrink_pct=50.0), candidates=[], analysis=None)
    stand_in = SimpleNamespace(run=lambda runs, options: SimpleNamespace(body=said, model=Scenario))
    patch.setattr(blind_inject, "diagnose_tendons", stand_in)
    found = blind_real.run([recording(offset=0.5)], diagnoser=answering([]))
    return [found.plain(), json.loads(inside("blind", "real", SAMPLE, "--inject", "all", "--json").stdout)]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict]:
    folder = tmp_path_factory.mktemp("documents")
    with pytest.MonkeyPatch.context() as patch:
        found = [*of_a_set(folder, patch), *of_a_library(folder), *of_a_rig(patch)]
    return {documents.short(d["schema"]): d for d in found}


def test_none_is_left_out(made: dict[str, dict]) -> None:
    # the others stand in tests/cli/test_cli_documents.py
    assert set(made) == {name for name in documents.catalogue() if name.startswith("blind.")} - {"blind.make"}


@pytest.mark.parametrize("name", ["run", "limit", "score", "library", "learn", "real", "inject"])
def test_every_document_validates(name: str, made: dict[str, dict]) -> None:
    assert checked(made[f"blind.{name}"])


def test_they_hold_what_was_made(made: dict[str, dict]) -> None:
    assert (made["blind.run"]["diagnosed"], made["blind.run"]["kept"]) == (0, 4)
    assert made["blind.limit"]["cases"] == made["blind.score"]["cases"] == len(made["blind.limit"]["distances"]) == 4
    assert made["blind.score"]["decidable"] and made["blind.score"]["by_d2"] and made["blind.score"]["verdicts"]
    assert made["blind.library"]["failed"] == 1 and made["blind.learn"]["left_out"] and made["blind.real"]["trials"]
    put_in = made["blind.inject"]["with_model"]
    assert put_in["of"] > 3 and put_in["named"] == 1 and put_in["untouched_named"] == 1
