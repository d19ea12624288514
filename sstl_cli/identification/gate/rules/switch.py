"""A channel of two values: a switch, a contact or a flag of the recorder, not a sensor."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import WORDS, column_line

RULE, RANK = "switch", 6
# a short run on a coarse converter may show two of its steps
LEAST_SAMPLES = 200
# of the larger of the two values
APART = 0.5


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs one of whose channels takes two values and no others, as in all runs of its system."""
    for i in (0, 1):
        # a sensor that shows more values in another run is one
        sensors = {(e.system, e.tendon) for e in log if e.usable and not e.two_values[i]}
        hit = [e for e in log if _switches(e, i) and (e.system, e.tendon) not in sensors]
        if hit:
            yield Remark(
                tuple(e.run_id for e in hit), RULE, "failure", 2.0, "1",
                f"{names([e.run_id for e in hit])}: the {WORDS[i]} takes two values and no others; it is probably a switch or a "
                "flag and not the sensor",
                column_line(i),
            )  # fmt: skip


def _switches(e: Evidence, i: int) -> bool:
    # beside an input that rests, two values may be the converter's last bit; a few stray samples are no second value
    # an on and an off are far apart, the last bit is not
    far = e.ranges[i].span > APART * e.ranges[i].largest
    moves = far and (i == 0 or e.loaded)
    return e.usable and e.samples >= LEAST_SAMPLES and e.two_values[i] and moves
