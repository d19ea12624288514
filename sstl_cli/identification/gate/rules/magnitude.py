"""Tensions that no tendon bears, or so small that nobody would measure them: another unit than N."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, Severity, names
from sstl_cli.identification.gate.units import plausible_units, stated

RULE, RANK = "magnitude", 12
# a 1 mm steel cable breaks at 0.6 to 0.9 kN, a 2 mm one at 2 to 3 kN, which no sheath of a hand's size carries
STRONG_N, IMPOSSIBLE_N = 700.0, 2000.0
# the finest tendons known, in catheters for eye and vessel, are pulled with tenths of a newton
WEAK_N, NOTHING_N = 0.1, 0.05


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose larger tension lies outside what tendons carry."""
    groups: dict[tuple[Severity, str], list[Evidence]] = {}
    for e in log:
        # loops between tensions that pull: a rod or a brake band may carry more
        if not e.tendon_like or e.correlation < 0.2:
            continue
        largest = max(r.largest for r in e.ranges)
        for limit, beyond, severity in (
            (IMPOSSIBLE_N, 1, "failure"), (STRONG_N, 1, "remark"), (NOTHING_N, -1, "failure"), (WEAK_N, -1, "remark"),
        ):  # fmt: skip
            if beyond * (largest - limit) > 0:
                groups.setdefault((severity, "large" if beyond > 0 else "small"), []).append(e)  # type: ignore[arg-type]
                break
    for (severity, kind), hit in groups.items():
        largest = (max if kind == "large" else min)(max(r.largest for r in e.ranges) for e in hit)
        units = plausible_units(largest)
        guess = " or ".join([*units, "raw counts" if kind == "large" else "volts"])
        why = "more than a tendon bears" if kind == "large" else "less than a tendon rig measures"
        yield Remark(
            tuple(e.run_id for e in hit), RULE, severity, largest, "N",
            f"{names([e.run_id for e in hit])}: tension up to {largest:.4g} N, {why}; the file probably holds {guess}, "
            "not N",
            "; ".join(stated(i, units[0] if units else "counts") for i in (0, 1)),
        )  # fmt: skip
