"""A channel that is renewed far more slowly than it is logged: no fault, but what it holds says nothing of the movement between."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, names
from sstl_cli.identification.gate.units import CHANNELS, WORDS

RULE, RANK = "refresh", 90
# samples of the log for one renewal, and times as many as of the other channel: amplifiers that send every few samples are usual
FAR, APART = 10, 4


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs one of whose channels is a sample-and-hold beside a fast one."""
    for i in (0, 1):
        hit = [
            e for e in log if e.tendon_like and e.held_while[i] > 0.0 and e.sensors[i].stride >= max(FAR, APART * e.sensors[1 - i].stride)
        ]
        if hit:
            s = hit[0].sensors[i]
            yield Remark(
                tuple(e.run_id for e in hit), RULE, "remark", 1.0 / s.refresh_s, "Hz",
                f"{names([e.run_id for e in hit])}: the {WORDS[i]} is renewed {1.0 / s.refresh_s:.3g} times a second in a log of {s.rate_hz:.4g} Hz and "
                "held between; no fault by itself, but it is late by up to one hold",
                f"none needed; record {CHANNELS[i]} at the rate of the log if fast movements matter",
            )  # fmt: skip
