"""Two recordings in one run: both channels jump at one sample, or the noise of both or friction changes for good."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names

RULE, RANK = "joined", 46
# jumps as a share of the span of each channel, and the factor between the noise of the halves
JUMP, NOISE = 0.15, 1.6
# part of the output's span that friction may leave of a run whose input leaps
FOLLOWED = 0.04


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs that consist of two recordings."""
    hit = [e for e in log if jumps(e)]
    if hit:
        size = max(min(e.seam) for e in hit)
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "remark", 100.0 * size, "%",
            f"{names([e.run_id for e in hit])}: input and output jump together, by {100 * size:.0f} % of their spans or more, "
            f"at {hit[0].seam_at_s:.4g} s; two recordings were probably joined to one run, samples lost there, or blocks of its rows exchanged",
            "[files] merge = \"no\" (or skip_samples / a time window that ends at the jump)",
        )  # fmt: skip
    yield from _leaping([e for e in log if e not in hit])
    hit = [e for e in log if e.tendon_like and _changes(e)]
    if hit:
        factor = max(max(max(r, 1.0 / r) for r in e.noise_ratio) for e in hit)
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "remark", factor, "1",
            f"{names([e.run_id for e in hit])}: the noise of both channels changes by a factor of {factor:.3g} within the run; "
            "two recordings (or two rigs) were probably joined to one run",
            "[files] merge = \"no\"",
        )  # fmt: skip
    parted = [(e, p) for e in log if e.tendon_like and not jumps(e) and (p := e.shapes.parted) is not None]
    for e, p in parted:
        before, after = p.wraps
        yield Remark(
            (e.run_id,), RULE, "remark", after / before, "1",
            f"{names([e.run_id])}: friction is n theta = {before:.3g} up to {p.at_s:.4g} s and {after:.3g} from there on, at one sample; recordings of two "
            "bends were probably joined to one run, or the bend was moved or the output's gain changed there",
            "[files] merge = \"no\" (or skip_samples / a time window that ends there)",
        )  # fmt: skip


def _leaping(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose input goes on from somewhere else while the output rests, as friction explains: no sensor changed there."""
    leaps = [(e, p) for e in log if (p := e.leap) is not None and e.tendon_like and e.shapes.change is None and _by_friction(e)]
    if leaps:
        ids, first = tuple(e.run_id for e, _ in leaps), leaps[0][1]
        size = max(p.share for _, p in leaps)
        beside = ", and so do the columns beside it" if all(p.confirmed for _, p in leaps) else ""
        yield Remark(
            ids, RULE, "remark", 100.0 * size, "%",
            f"{names(ids)}: the input leaps by {100 * first.share:.0f} % of its span at {first.at_s:.4g} s, many times as far as in any other step{beside}, and the clock shows no gap; rows were "
            "probably lost there while the output rested, or two recordings joined to one run",
            "[files] merge = \"no\" (or skip_samples / a time window that ends at the jump), and a clock that counts the lost rows",
        )  # fmt: skip


def _by_friction(e: Evidence) -> bool:
    """Whether friction alone goes on over a leap: an input sensor with another zero from there on would not be followed."""
    return e.causes.enough or e.causes.least_n(e.duration_s) < FOLLOWED * e.ranges[1].span


def jumps(e: Evidence) -> bool:
    """Whether both channels go on far away from where they were at one sample."""
    return e.tendon_like and min(e.seam) > JUMP and (_wide(e) or e.seam_alone)


def _wide(e: Evidence) -> bool:
    """Whether loops reach over most of the tensions, so that a jump is no small change of a high level."""
    return all(r.span > 0.5 * r.largest for r in e.ranges)


def _changes(e: Evidence) -> bool:
    first, second = e.noise_ratio
    return (first > NOISE and second > NOISE) or (0.0 < first < 1.0 / NOISE and 0.0 < second < 1.0 / NOISE)
