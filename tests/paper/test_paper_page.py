"""Sentences of docs/reproduction.md say what the committed numbers say, and the fitted ones what the code has."""

from __future__ import annotations

from pathlib import Path

from sstl_cli.paper.compare import MET, compare
from sstl_cli.paper.published import of_table
from sstl_cli.paper.settings import FITTED
from sstl_cli.paper.spread import stored
from sstl_cli.physics.generator import PLACES

TEXT = " ".join((Path(__file__).parents[2] / "docs/reproduction.md").read_text(encoding="utf-8").split())
NETWORKS = ("plain", "plain-inv", "skip", "skip-inv")


def ends(values: list[float], digits: int) -> str:
    """Return the smallest and the largest number, one where both are written alike."""
    return "-".join(dict.fromkeys(f"{v:.{digits}f}" for v in (min(values), max(values))))


def test_the_errors_of_table_iii_over_data_sets() -> None:
    known = stored("III").of("III")
    mean, sd = known["III", "linear", "total"]
    totals = [known["III", n, "total"] for n in NETWORKS]
    (own,) = {f"{sd:.4f}" for _, sd in totals}
    assert f"Linear regression {mean:.4f} +- {sd:.4f} (paper 0.0193)" in TEXT
    assert f"the four networks {ends([m for m, _ in totals], 4)} +- {own} (paper 0.0166-0.0173)" in TEXT
    judged = compare(of_table("III"), {k: m for k, (m, _) in known.items()}, known, "stated")
    met = [c for c in judged if c.verdict == MET]
    assert f"all {len(met)} entries within 2 sd" in TEXT and len(met) == len([c for c in judged if c.ours is not None])


def test_the_spreads_of_table_iii_stand_apart() -> None:
    known, spread = stored("III").of("III"), stored("III")
    sets = [known["III", m, "total"][1] for m in ("linear", *NETWORKS)]
    seeds = [spread.of("III seeds")["III", n, "total"][0] for n in NETWORKS]
    samples = [[spread.of("III samples")["III", m, f"rmse_{d}"][0] for m in ("linear", *NETWORKS)] for d in "pr"]
    assert f"over data sets {ends(sets, 4)}, over training seeds {ends(seeds, 4)}" in TEXT
    assert f"over held-out samples {ends(samples[0], 3)} (pull) and {ends(samples[1], 3)} (release)" in TEXT


def test_block_r_with_its_first_cycle_and_beside_print() -> None:
    whole, rig = stored("R").of("rig, whole"), stored("R").of("rig")
    shares = [whole["headline", "proposed", name] for name in ("red", "recovery")]
    said = " and ".join(f"{m:.1f} +- {s:.1f}" for m, s in shares)
    assert f"With the first cycle the last two are {said} %" in TEXT
    assert f"The mapping errs by {rig['III', 'skip-inv', 'total'][0]:.4f} on bends held out of training" in TEXT
    judged = [c for c in compare(of_table("IV"), {k: m for k, (m, _) in rig.items()}, rig, "rig") if c.ours is not None]
    below = {
        row: [-c.relative_pct for c in judged if c.entry.row == f"sinusoid {row}" and c.entry.column.startswith("rmse") and c.relative_pct]
        for row in ("none", "no-bias")
    }
    assert all(len(v) == 3 for v in below.values())
    assert f"lie {ends(below['none'], 0)} % and {ends(below['no-bias'], 0)} % below print on the sinusoid" in TEXT


def test_what_was_fitted_is_what_the_code_has() -> None:
    lines = FITTED.lines
    assert f"a reference of {FITTED.offset_n:g} +- {FITTED.amplitude_n:g} N" in TEXT
    assert (
        f"lines ({lines.gamma_p:g}, {lines.beta_p:g} N), ({lines.gamma_r:g}, {lines.beta_r:g} N), a lag of {FITTED.lag_s:g} s and a "
        f"mismatch of {FITTED.mismatch:g} rad" in TEXT
    )
    proximal, central, distal = PLACES
    assert f"bend gain ({proximal.bend_gain:g} / {distal.bend_gain:g}), friction that the bend adds to the loop ({proximal.pull:g})" in TEXT
    assert proximal.pull == distal.release and proximal.scatter == distal.scatter and central.scatter == 1.0
    assert f"({proximal.scatter:g} times CP's)" in TEXT
