"""A part of one channel in the other one: their noises go together in some runs of a system and not in its others."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.noises import ENOUGH
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import CHANNELS

RULE, RANK = "crosstalk", 84
# correlation of the noises of both channels where one holds a part of the other, most where none does, and fewest runs that show none
SHARED, OWN, FEWEST = 0.2, 0.1, 3
# standard errors that a correlation must be beyond chance; those of second differences of white noise, whose neighbours go against each other, are 1.39 over the root of their number
ERRORS, ERROR = 5.0, 1.39
# logarithm by which a noise differs from run to run by chance: some 1500 samples tell it to 2 %
CHANCE = 0.05


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose channels share a part of their noise, where those of the other runs share none."""
    known = [e for e in log if e.tendon_like and all(s.white and not s.held for s in e.sensors) and e.hums == (None, None)]
    rest = [e for e in known if not abs(e.noise_correlation) > max(SHARED, ERRORS * ERROR / math.sqrt(min(e.samples, ENOUGH)))]
    # amplifiers on one supply share a noise in all runs of their system: there is no run that tells what each has of its own
    hit = [e for e in known if e not in rest and any(o.system == e.system for o in rest)]
    hit = [e for e in hit if not _supplied(e, [o for o in rest if o.system == e.system])]
    if hit and len(rest) >= max(FEWEST, len(hit)) and all(abs(e.noise_correlation) < OWN for e in rest):
        most = max((e.noise_correlation for e in hit), key=abs)
        yield Remark(
            tuple(e.run_id for e in hit), RULE, "remark", most, "1",
            f"{names([e.run_id for e in hit])}: the noise of input and output goes together (correlation {most:.2g}), and not in the other runs; a part of "
            "one channel is probably in the other one (amplifiers, cables), or the column is a sum or difference of both",
            f"{CHANNELS[1]} = {{ column = (the column of the output sensor alone) }}",
        )  # fmt: skip


def _supplied(e: Evidence, rest: Sequence[Evidence]) -> bool:
    """Whether both noises are more than in the other runs, as what comes from a supply or a hum adds to both; a part of one channel adds to the other one alone."""
    grown = []
    for i in (0, 1):
        noises = [o.sensors[i].noise_n for o in rest]
        usual = float(np.median(noises))
        # a noise that varies by itself says nothing by being the largest
        varies = math.log(max(noises) / usual) if usual > 0.0 else math.inf
        grown.append(usual > 0.0 and math.log(max(e.sensors[i].noise_n, 1e-300) / usual) > max(CHANCE, varies))
    return all(grown)
