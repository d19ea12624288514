"""Input and output exchanged: the tension grows on its way through the sheath, and the input follows the output."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.rules.stuck import silent

RULE, RANK = "swapped", 27
# residual of the exchanged record over that of the record as it is, and as a share of the span
BETTER, GOOD = 0.5, 0.06
# correlation from which on a loop is one; a wide one of two passes has less, and is believed where exchanged it leaves but noise (times the input's) and
# this part of what it leaves as recorded
GOES_ALONG, TO_NOISE, MUCH_BETTER = 0.2, 2.0, 0.1
# what the exchanged record may leave of what the record leaves, both without a delay, where most runs are exchanged and friction explains none: cables are exchanged for all of them
LIKELIER = 0.8


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs that are hysteresis loops only with the channels exchanged, and those in which the channels change places."""
    crossed = [e for e in log if e.both_tensions and e.crossing is not None]
    yield from map(_midway, crossed)
    log = [e for e in log if e not in crossed]
    hit = swapped(log)
    if not hit:
        return
    slope = max((e.slopes.gamma_p for e in hit if e.slopes.gamma_p == e.slopes.gamma_p), default=float("nan"))
    said = f" (slope of the pull {slope:.3g}, above 1)" if slope > 1.0 else ""
    share = max(e.swapped_rms / max(_as_recorded(e), 1e-300) for e in hit if _exchanged(e))
    # a wide loop that is never released stays where it was pulled to, and so does a sensor that was lost there
    lost = ", or the input was lost where it stays from its first rise on" if all(e.loops == 0 for e in hit) else ""
    number, unit = (slope, "1") if slope > 1.0 else (100.0 * share, "%")
    yield Remark(
        tuple(e.run_id for e in hit), RULE, "failure", number, unit,
        f"{names([e.run_id for e in hit])}: the input follows the output{said}, and exchanged they fit a hysteresis loop with "
        f"{100 * share:.0f} % of the error; input and output are probably swapped{lost}",
        "tension_in_n = (the column of tension_out_n); tension_out_n = (the column of tension_in_n)",
    )  # fmt: skip


def _midway(e: Evidence) -> Remark:
    """Return what is said of a run both channels of which go to where the other was, at one sample."""
    assert e.crossing is not None
    at, apart = e.crossing.at_s, e.crossing.apart_n
    till = f" to {at[1]:.4g} s" if len(at) == 2 else " on" if len(at) == 1 else f" on, and {len(at) - 1} times more later"
    return Remark(
        (e.run_id,), RULE, "failure", apart, "N",
        f"{names([e.run_id])}: at {at[0]:.4g} s input and output each go to where the other one was, {apart:.3g} N away, in one step; the channels are probably exchanged "
        f"from {at[0]:.4g} s{till}",
        "[files] merge = \"no\" (or a time window that ends there); beyond it tension_in_n = (the column of tension_out_n) and tension_out_n = (the column of tension_in_n)",
    )  # fmt: skip


def swapped(log: Sequence[Evidence]) -> list[Evidence]:
    """Return the runs that are loops only with the channels exchanged, and those that go with them."""
    hit = [e for e in log if e.usable and e.play is not None and _exchanged(e)]
    return _with_rest(hit, log) if hit else []


def _with_rest(hit: list[Evidence], log: Sequence[Evidence]) -> list[Evidence]:
    """Return the exchanged runs, with those that alone would not tell where most are exchanged and none is explained as it stands."""
    usable = [e for e in log if e.usable and e.play is not None and e.both_tensions]
    if 2 * len(hit) <= len(usable) or any(e.causes.enough for e in usable):
        return hit
    return [e for e in usable if e in hit or e.swapped_rms < LIKELIER * e.forward_rms]


def _as_recorded(e: Evidence) -> float:
    assert e.play is not None
    faded = e.causes.fading.rms_n
    return min(e.play.rms_n, e.play.delayed_rms_n, faded if math.isfinite(faded) else math.inf) / max(e.ranges[1].span, 1e-300)


def _exchanged(e: Evidence) -> bool:
    if silent(e):
        return False
    # what is left must be more than noise
    told = _as_recorded(e) * e.ranges[1].span > 2.0 * max(e.sensors[1].noise_n, 0.3 * e.sensors[1].step_n)
    if not told or not e.swapped_rms < min(GOOD, BETTER * _as_recorded(e)):
        return False
    but_noise = e.swapped_rms * e.ranges[0].span < TO_NOISE * e.sensors[0].noise_n and e.swapped_rms < MUCH_BETTER * _as_recorded(e)
    return e.correlation > GOES_ALONG or (but_noise and e.correlation > 0.0 and e.tendon_like)
