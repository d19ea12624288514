"""Diagnose the difference between the paper's tracking and ours under the stated settings: which effect closes it?"""

from __future__ import annotations

from dataclasses import dataclass

from sstl_cli.steps import diagnose
from sstl_cli.steps.against import rebase
from sstl_cli.steps.reproduce_gap import logs
from sstl_cli.steps.reproduce_tracking import Block, Prepared

# a third effect costs as long again and never joined the first two
MAX_EFFECTS = 2
WORKERS = 2


@dataclass(frozen=True)
class Leading:
    """One model that was compared: its effects and the held-out RMSE (N) that it leaves."""

    effects: str
    rmse_n: float
    shrink_pct: float


@dataclass(frozen=True)
class Named:
    """The verdict on the difference, and how far it shrinks (RMSE in N: re-tuned, noise floor)."""

    sentence: str
    status: str
    effects: tuple[str, ...]
    beside: str
    retuned_n: float
    floor_n: float
    leading: tuple[Leading, ...]


def run(prepared: Prepared, explained: Block, seed: int) -> Named:
    """Return the diagnosis of the runs under the explaining settings against the prediction of the stated ones.

    The explaining settings stand in for the paper's recordings, which nobody published.
    """
    measured, simulated = logs(prepared, explained, seed)
    runs = rebase(list(measured), list(simulated))
    body = diagnose.run(runs, diagnose.DiagnoseOptions(max_effects=MAX_EFFECTS, workers=WORKERS)).document()
    beside = body.get("beside")
    rows = [c for c in body["candidates"] if c["rmse_held_out_n"] is not None]
    leading = [Leading(c["id"], c["rmse_held_out_n"], c["shrink_pct"]) for c in rows]
    return Named(
        body["sentence"],
        body["verdict"]["status"],
        tuple(body["verdict"]["effects"]),
        "" if beside is None else f"{', '.join(beside['effects'])}: {beside['rmse_base']:.2f} -> {beside['rmse_with_effect']:.2f} N",
        body["gap"]["rmse_retuned_n"],
        body["gap"]["noise_floor_n"],
        tuple(sorted(leading, key=lambda x: x.rmse_n)[:4]),
    )
