"""A part of one channel in the other one: their noises go together in some runs and not in the others."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import CHANNELS

RULE, RANK = "crosstalk", 84
# correlation of the noises of both channels where one holds a part of the other, most where none does, and fewest runs that show none
SHARED, OWN, FEWEST = 0.2, 0.1, 3


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose channels share a part of their noise, where those of the other runs share none."""
    known = [e for e in log if e.tendon_like and all(s.white and not s.held for s in e.sensors) and e.hums == (None, None)]
    hit = [e for e in known if abs(e.noise_correlation) > SHARED]
    rest = [e for e in known if not abs(e.noise_correlation) > SHARED]
    if hit and len(rest) >= max(FEWEST, len(hit)) and all(abs(e.noise_correlation) < OWN for e in rest):
        most = max((e.noise_correlation for e in hit), key=abs)
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "remark", most, "1",
            f"{names([e.run_id for e in hit])}: the noise of input and output goes together (correlation {most:.2g}), and not in the other runs; a part of "
            "one channel is probably in the other one (amplifiers, cables), or the column is a sum or difference of both",
            f"{CHANNELS[1]} = {{ column = (the column of the output sensor alone) }}",
        )  # fmt: skip
