"""One channel without any noise beside a measured one: a command, a copy that was smoothed, or a sensor behind a low-pass."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.rules.unrelated import unexplained
from sstl_cli.identification.gate.units import WORDS, column_line

RULE, RANK = "noiseless", 82
# noise over that of the other channel: amplifiers differ by ten, a load cell and a number in a program by more
LESS = 0.02
# a command is rounded as numbers are, and ahead of what is measured: noise that is but rounding, and a delay (s) that no tube has
ROUNDED, AHEAD, AHEAD_S = 0.05, 6.0, 0.1
# n theta that no command and no copy of the input shows, whatever low-pass it comes behind, and what friction may leave of the output's span
PLAIN, EXPLAINED = 0.05, 0.03


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs one of whose channels was not measured."""
    for i in (0, 1):
        # a sensor whose noise shows in half of its system's runs is one in all of them
        measured = {system for system in {e.system for e in log} if _shows(log, system, i)}
        hit = [e for e in log if e.tendon_like and smooth(e, i) and e.system not in measured]
        if hit:
            hit = [e for e in log if e in hit or _rests_smooth(e, i, hit)]
            e = hit[0]
            number = _noise(e, i) / e.sensors[1 - i].noise_n
            computed = e.sensors[i].computed
            has = (
                "is smooth down to the rounding of its digits, without the noise" if computed else f"has {100 * number:.2g} % of the noise"
            )
            why, line = _why(hit, i)
            yield Remark(
                tuple(h.run_id for h in hit), RULE, "remark", number, "1",
                f"{names([h.run_id for h in hit])}: the {WORDS[i]} {has} of the {WORDS[1 - i]}; {why}",
                line,
            )  # fmt: skip


def _rests_smooth(e: Evidence, i: int, hit: Sequence[Evidence]) -> bool:
    """Whether a channel that rests for long, so that its digits show as steps, is as quiet as that of the other runs of the system."""
    s, other = e.sensors[i], e.sensors[1 - i]
    beside = e.tendon_like and any(o.system == e.system for o in hit) and e.hums[1 - i] is None and not (s.held or other.held)
    return beside and max(s.noise_n, 0.3 * s.step_n) < LESS * other.noise_n


def _why(hit: Sequence[Evidence], i: int) -> tuple[str, str]:
    """Return what probably took the noise away, and the line that mends it."""
    if i == 1 and 2 * sum(_rubs(e) for e in hit) >= len(hit):
        why = "friction is plain in it, so that it is a sensor behind a low-pass, or was smoothed or interpolated afterwards"
        return why, f"none needed if the amplifier filters so, or {column_line(i)}"
    return "it is probably the command or a smoothed copy and not the sensor", column_line(i)


def _rubs(e: Evidence) -> bool:
    """Whether friction explains the output, also behind a low-pass of its own: a copy that is late makes a loop, too, but loses nothing behind it."""
    slow = e.causes.slow.wrap
    return e.wrap > PLAIN and not slow <= PLAIN and unexplained(e) < EXPLAINED


def _shows(log: Sequence[Evidence], system: str, i: int) -> bool:
    runs = [e for e in log if e.usable and e.system == system]
    return 2 * sum(_noise(e, i) > (ROUNDED if _ahead(e, i) else LESS) * e.sensors[1 - i].noise_n for e in runs) >= len(runs)


def _noise(e: Evidence, i: int) -> float:
    """Return the noise of a channel (N), where it is computed that of its rounding."""
    s = e.sensors[i]
    return s.rounding_n if s.computed else s.noise_n


def smooth(e: Evidence, i: int) -> bool:
    """Whether a channel (0 input, 1 output) lacks the noise that the other one shows, so that it was hardly measured."""
    this, other = e.sensors[i], e.sensors[1 - i]
    # beside hum any sensor is quiet
    if e.hums[1 - i] is not None or this.held or other.held or other.noise_n <= 1e-4 * e.ranges[1 - i].span:
        return False
    # nor is a channel whose noise hides between its levels
    plain = all(s.step_n < 0.5 * s.noise_n or s.step_n == 0.0 or s.computed for s in (this, other))
    return (plain and _noise(e, i) < LESS * other.noise_n) or (
        _ahead(e, i) and max(this.noise_n, 0.3 * this.step_n) < ROUNDED * other.noise_n
    )


def _ahead(e: Evidence, i: int) -> bool:
    """Whether an input is rounded, without noise of its own, and the output later than any tube makes it."""
    p, s = e.play, e.sensors[i]
    if i == 1 or p is None or not e.wide or not e.causes.holds(e.causes.moved.rms_n):
        return False
    return (not s.white or s.step_n > 0.5 * s.noise_n) and p.delay_s > max(AHEAD_S, AHEAD * p.delay_se)
