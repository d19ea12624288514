"""What ``watch`` says to people: a heading, one line a loop, alarms, and a last sentence."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sstl_cli.steps.watch import Loop

# columns, and digits behind the point: a loop tells slopes to a thousandth, biases to millinewtons
FORMS = {"gamma_p": (6, 4), "beta_p": (7, 3), "gamma_r": (6, 4), "beta_r": (7, 3)}
STREAMS = 4


def heading(unit: str) -> str:
    """Return the names of the columns of ``loop``; ``unit`` is that of the output."""
    names = ("Γ_p", f"β_p {unit}", "Γ_r", f"β_r {unit}")
    lines = " ".join(f"{name:>{columns}}" for name, (columns, _) in zip(names, FORMS.values(), strict=True))
    return f"{'loop':>5} {'stream':12} {'time s':13} {lines} {f'gap {unit}':>7} chart"


def loop(found: Loop, width: int) -> list[str]:
    """Return a loop as one line of at most ``width`` columns; what has no room in it stands indented below."""
    run, theta = found.run, found.segmentation.theta
    place = " ".join([run.system, *filter(None, (run.tendon, run.config_id))])
    time = f"{run.time_s[0]:.1f}-{run.time_s[-1]:.1f}"
    values = " ".join(_number(theta[p], *form) for p, form in FORMS.items())
    gap = "-" if found.gap_n is None else f"{found.gap_n:.4f}"
    chart = "learning" if found.learning else f"{100 * found.level:.0f} %"
    line = f"{found.number:5d} {place:12} {time:13} {values} {gap:>7} {chart}"
    more = [f"-> act {found.mapped[0]:.4f} {found.mapped[1]:.4f}"] if found.mapped is not None else []
    more += [f"{found.range} range"] if found.range in ("edge", "outside") else []
    more += [found.segmentation.status] if found.segmentation.status != "ok" else []
    said = "; ".join(more)
    if not said:
        return [line]
    return [f"{line}  {said}"] if len(line) + 2 + len(said) <= width else [line, f"      {said}"]


def summary(loops: int, samples: int, alarms: int, learning: dict[str, int], learn: int) -> str:
    """Return what was seen; where a stream is still learning, that no alarm means little is said instead of 0 alarms."""
    waiting = ", ".join(f"{name} {n} of {learn} loops" for name, n in list(learning.items())[:STREAMS])
    more = f" and {len(learning) - STREAMS} more" if len(learning) > STREAMS else ""
    told = f"not armed: {waiting}{more}" if learning else ""
    counted = f"{alarms} alarms" if alarms or not learning else ""
    return f"{loops} loops in {samples} samples, " + "; ".join(t for t in (counted, told) if t)


def _number(value: float | None, columns: int, digits: int) -> str:
    return f"{'-':>{columns}}" if value is None else f"{value:{columns}.{digits}f}"
