"""A gap that was filled: both channels are straight lines in time, without the noise that they have before and after."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from sstl_cli.identification.gate.dropouts import MEND
from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, Severity, names
from sstl_cli.identification.gate.rules.stuck import FAILED_SHARE
from sstl_cli.identification.gate.units import WORDS

RULE, RANK = "filled", 43
# shorter ones (s) bridge a few lost samples, as an import may
LEAST_S = 0.1


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs part of which was interpolated."""
    shares = {e.run_id: e.filled.length_s / max(e.duration_s, 1e-300) for e in log if e.usable and e.filled.length_s > LEAST_S}
    severities: tuple[Severity, ...] = ("failure", "remark")
    for severity in severities:
        hit = [e for e in log if e.run_id in shares and (shares[e.run_id] > FAILED_SHARE) == (severity == "failure")]
        if hit:
            f = max((e.filled for e in hit), key=lambda v: v.length_s)
            yield Remark(
                tuple(e.run_id for e in hit), RULE, severity, f.length_s, "s",
                f"{names([e.run_id for e in hit])}: from {f.at_s:.4g} s on input and output are straight lines for {f.length_s:.3g} s, without the noise "
                "that they have elsewhere; a gap was probably filled by interpolation",
                "split the run there, or skip this stretch",
            )  # fmt: skip
    yield from _dropped(log)


def _dropped(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs in which readings of one channel are missing, and one number or a bare amplifier stands for them."""
    for i in (0, 1):
        hit = [(e, d) for e in log if e.usable and (d := e.dropouts[i]) is not None]
        if hit:
            d = max((d for _, d in hit), key=lambda v: v.samples)
            why = (
                "missing samples were probably filled with that number, or it is an error code"
                if d.filled
                else "its connector probably let go"
            )
            yield Remark(
                tuple(e.run_id for e, _ in hit), RULE, "remark", float(d.samples), "samples",
                f"{names([e.run_id for e, _ in hit])}: the {WORDS[i]} jumps to {d.level_n:.4g} N {d.stretches} times and back to where it was ({d.samples} samples) "
                f"while the {WORDS[1 - i]} goes on; {why}",
                MEND,
            )  # fmt: skip
