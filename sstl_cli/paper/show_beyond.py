"""What lies beyond the paper, said: tables and sentences of the parts that its conclusion leaves to future work."""

from __future__ import annotations

from sstl_cli.paper.better import ALL_MEANS, TARGETS_N, Calibration
from sstl_cli.paper.grid import Grid, number
from sstl_cli.paper.lag_and_presliding import PRESLIDING
from sstl_cli.paper.probe import BENDS_EACH, curves, shortest
from sstl_cli.paper.reproduce import Reproduction
from sstl_cli.paper.reversal import MOVED_N
from sstl_cli.paper.rig import GAP, LAG_S
from sstl_cli.paper.settings import LOCATIONS, TRAJECTORIES


def grids(found: Reproduction) -> list[Grid]:
    """Return the tables of what was identified, of the means, reversal regions, probes, tendons and the joint."""
    return [*_identified(found.calibration), *_better(found), *_reversal(found), *_probe(found), *_tendons(found), *_distal(found)]


def facts(found: Reproduction) -> list[str]:
    """Return the sentences that sum these tables up."""
    said = []
    if found.better:
        rung = next(r for r in found.better if r.name == ALL_MEANS)
        said.append(
            "Better than the paper, without distal sensor: "
            + ", ".join(f"{t} {rung.mean(t):.2f} N (target {limit:.2f})" for t, limit in TARGETS_N.items())
            + "."
        )
    for (rig, calibration), probes in curves(found.probes).items():
        a, b = shortest(probes, "lines_error"), shortest(probes, "tracking_n")
        said.append(
            f"Shortest probe within 10 % of 12 s, {rig}, calibrated at {calibration}: {a.time_s:.2g} s by Theta ({a.kind}), "
            f"{b.time_s:.2g} s by tracking ({b.kind})."
        )
    return said


def _identified(made: Calibration | None) -> list[Grid]:
    if made is None:
        return []
    rows = [("loop lag, s", f"{LAG_S:.4f}", f"{made.lag.tau_s:.4f} +-{made.lag.error_s:.4f}")]
    rows += [
        (f"{effect} {p}", f"{GAP[effect][p]:.3f}", f"{made.presliding.values[effect, p]:.3f}")
        for effect, values in PRESLIDING.items()
        for p in values
    ]
    note = (
        "lag: from command and measured input tension of one trapezoid; presliding: from one recording of small loops at "
        f"each of six calibration bends ({made.presliding.rms_n:.2f} N are left; the rig's friction at low speed is not "
        "in that simulator)."
    )
    return [Grid("identified", "Identified from recordings", ("what", "the rig's", "identified"), tuple(rows), (note,))]


def _better(found: Reproduction) -> list[Grid]:
    if not found.better:
        return []
    rows = tuple((r.name, *(number(v, 2) for t in TRAJECTORIES for v in (*r.rmse_n[t], r.mean(t)))) for r in found.better)
    published = " and ".join(f"{TARGETS_N[t]:.2f}" for t in TRAJECTORIES)
    return [
        Grid(
            "better",
            "The rig with the paper's gap: RMSE (N) at NP, CP, ND and mean; sinusoid, then random",
            ("means", *(*LOCATIONS, "mean") * 2),
            rows,
            (f"Paper's direct identification: {published} N. One held-out bend a location; without the first cycle.",),
        )
    ]


def _reversal(found: Reproduction) -> list[Grid]:
    if not found.better:
        return []
    measures = ("reversal_n", "elsewhere_n", "peak_n")
    rows = tuple((r.name, *(number(r.mean(t, m), 2) for t in TRAJECTORIES for m in measures)) for r in found.better)
    return [
        Grid(
            "reversal",
            "The reversal region: RMSE (N) in it and elsewhere, largest error in it; sinusoid, then random",
            ("means", *("turn", "else", "peak") * 2),
            rows,
            (f"turn: until the reference has moved {MOVED_N:g} N away from its last turn; mean over the bends.",),
        )
    ]


def _probe(found: Reproduction) -> list[Grid]:
    rows = tuple(
        (
            p.kind,
            number(p.time_s, 2),
            number(p.top_n, 0),
            number(100 * p.lines_error, 2),
            number(None if p.segmented_error is None else 100 * p.segmented_error, 2),
            number(p.tracking_n, 3),
        )
        for p in found.probes
    )
    header = ("probe", "s", "top N", "slopes %, fit", "slopes %, segm.", "RMSE N")
    note = "fit: one theta fitted to the whole recording; segm.: segmentation and linear map, '-' where a bend shows no release line."
    done = []
    for (rig, calibration), probes in curves(found.probes).items():
        own = tuple(row for row, p in zip(rows, found.probes, strict=True) if p in probes)
        name = f"probe-{rig}-{calibration}".replace(" ", "-")
        title = f"A shorter probe: {rig}, calibrated at {calibration}; {BENDS_EACH * len(LOCATIONS)} bends"
        done.append(Grid(name, title, header, own, (note,)))
    return done


def _tendons(found: Reproduction) -> list[Grid]:
    if not found.tendons:
        return []
    names = tuple(found.tendons[0].rmse_n)
    rows = tuple(
        (t.way, f"{t.crosstalk_per_n:g}", f"{t.identified_per_n:.5f}", *(number(v, 2) for v in t.rmse_n.values())) for t in found.tendons
    )
    note = (
        "Tendons that share a tube and its sensing loop follow random references of their own at once (5-30 N, 200 s); mean over "
        "one bend a location. c: by which share a neighbour's newton opens the bend."
    )
    return [Grid("tendons", "Several tendons tracked at once: RMSE (N)", ("way", "c 1/N", "found", *names), rows, (note,))]


def _distal(found: Reproduction) -> list[Grid]:
    if not found.distal:
        return []
    rows = tuple((b.way, *(number(v[t], 2) for v in (b.rmse_n, b.rmse_deg) for t in TRAJECTORIES)) for b in found.distal)
    one = found.distal[0]
    note = (
        f"The joint turns 2 degrees a newton; mu kappa {one.joint_per_n:.5f}, found {one.identified_per_n:.5f} 1/N from one movement "
        "with the joint held and free. Simulated, mean over one bend a location."
    )
    header = ("way", *(f"{t} {unit}" for unit in ("N", "deg") for t in TRAJECTORIES))
    return [Grid("distal", "An actively bending distal joint: RMSE", header, rows, (note,))]
