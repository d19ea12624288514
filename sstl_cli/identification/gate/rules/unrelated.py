"""An output that does not follow its input: files or columns of different recordings put together."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import MOST_WRAP, Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.rules.dead import lost_by
from sstl_cli.identification.gate.units import column_line

RULE, RANK = "unrelated", 48
# rules that say why an output does not follow as it stands
AFTER = (
    "limit", "overflow", "gain", "gain_change", "zero_change", "folded", "lead", "slow", "curved", "drift", "zero", "filled", "dead", "stuck", "joined",
)  # fmt: skip
# share of the output's variance that lines, a delay and a drift explain of no other recording's output
RELATED = 0.95
# how much the output must move (share of the input): within backlash it shows but presliding
MOVES = 0.15
# part of the run that an output may be late by if the delay explains it but half
FAR, CLEAR = 0.02, 0.9
# what friction, alone and with any slip, leaves (share of the output's span) beyond the noise
NOTHING = 0.12
# part of what is left as recorded that another sign must leave for it to be the sign
SIGN = 0.6


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose output moves, but not as any friction would move it."""
    every = [e for e in log if unrelated(e)]
    still, hit = [e for e in every if e.but_noise(0)], [e for e in every if not e.but_noise(0)]
    if still:
        e = max(still, key=lambda e: e.ranges[1].span)
        yield Remark(
            tuple(e.run_id for e in still), RULE, "remark", e.ranges[1].span, "N",
            f"{names([e.run_id for e in still])}: the input is noise about a constant ({e.ranges[0].middle:.3g} N) while the output moves by "
            f"{e.ranges[1].span:.3g} N, which nothing but the input drives; the input's sensor is probably dead or not connected, or input and output come from different recordings",
            column_line(0),
        )  # fmt: skip
    if hit:
        number = min(explained_by(e) for e in hit)
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "remark", 100.0 * max(number, 0.0), "%",
            f"{names([e.run_id for e in hit])}: friction, backlash and delay explain {100 * max(number, 0.0):.0f} % of the "
            "output; input and output probably come from different recordings",
            "[files] merge = \"channels\", key = (the named group that tells which files belong together)",
        )  # fmt: skip


def follows(e: Evidence) -> bool:
    """Whether the output moves by more than presliding within the backlash moves it, or its sensor's slow noise."""
    return e.ranges[1].span > MOVES * e.ranges[0].span


def explained_by(e: Evidence) -> float:
    """Return the share of the output's variance that is explained; of other movements a long delay always explains some."""
    p = e.play
    if p is None or p.explained > CLEAR or abs(p.delay_s) < FAR * e.duration_s:
        return p.explained if p is not None else 1.0
    return 1.0 - (1.0 - p.explained) * (p.rms_n / max(min(p.rms_n, p.delayed_rms_n), 1e-300)) ** 2


def unrelated(e: Evidence) -> bool:
    """Whether no friction moves the output as it moves."""
    if max(lost_by(e, 0), lost_by(e, 1)) > MOST_WRAP:
        # a sensor that was lost midway follows nothing from there on
        return False
    flipped = e.correlation < -0.4 and not e.flipped_rms > SIGN * e.forward_rms
    if not e.tendon_like or flipped or e.but_noise(1):
        return False
    return follows(e) and unexplained(e) > NOTHING and not explained_by(e) >= RELATED


def unexplained(e: Evidence) -> float:
    """Return what friction, alone and with any slip, leaves of the output beyond noise (share of its span), NaN where that is not known."""
    # lines that explain the output are related to it, whether or not friction has such lines
    left = min(e.causes.least_n(e.duration_s), math.inf if e.play is None else e.play.rms_n)
    # an input that is but noise tells no movement: of the output its own noise alone is explained
    noise = e.sensors[1].noise_n if e.but_noise(0) else e.causes.noise_n
    return math.sqrt(max(left**2 - noise**2, 0.0)) / max(e.ranges[1].span, 1e-300)
