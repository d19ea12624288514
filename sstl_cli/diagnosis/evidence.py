"""How much one model's scores over blocks of time say against another's."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis.whitening import fit_whitener

Array = NDArray[np.float64]
BLOCK_S = 5.0


class Scored(Protocol):
    """Anything with a log score (nats), in all and per block."""

    @property
    def score(self) -> float: ...

    @property
    def blocks(self) -> Array: ...


@dataclass(frozen=True)
class Score:
    """Log score (nats, up to a constant) in all and per block."""

    score: float
    blocks: Array


def advantage(a: Scored, b: Scored, few: float = 50.0) -> float:
    """Return by how many nats ``a`` beats ``b``, discounted where blocks disagree.

    A well-specified log-score difference d has variance 2 d; where blocks vary more, at most 2 z^2 nats count.
    """
    d, z = a.score - b.score, errors(a, b)
    # a huge difference counts even where it sits in a few blocks
    return float(np.sign(d) * min(abs(d), max(2.0 * z * z, abs(d) / few)))


def errors(a: Scored, b: Scored) -> float:
    """Return the difference of two models' log scores in its standard errors over blocks."""
    diff = a.blocks - b.blocks
    return float(diff.sum() / np.sqrt(len(diff) * diff.var() + 1e-12))


def block_index(lengths: Sequence[int], steps_s: Sequence[float]) -> NDArray[np.int64]:
    """Return the index of the time block (about 5 s, within one run) of each sample of runs laid end to end."""
    parts, offset = [], 0
    for n, step in zip(lengths, steps_s, strict=True):
        parts.append(offset + np.arange(n) // max(1, round(BLOCK_S / step)))
        offset = int(parts[-1][-1]) + 1 if n else offset
    return np.concatenate(parts)


def block_scores(white: Array, index: NDArray[np.int64]) -> Array:
    """Return the log score (nats, up to a constant) of each block."""
    return np.asarray(-0.5 * np.bincount(index, white**2))


def scores(
    residuals: Sequence[Array], parameters: Sequence[int], best: int, lengths: Sequence[int], steps_s: Sequence[float]
) -> list[Score]:
    """Return the scores of several models of one channel, with the noise taken from what the best one leaves.

    Parameters
    ----------
    residuals : sequence of ndarray, shape (samples,)
        What each model leaves, runs laid end to end.
    parameters : sequence of int
        Free parameters of each; the charge is half a log-sample for each.
    best : int
        Index of the model whose residual is closest to noise.
    """
    ends = np.cumsum(lengths)
    slices = [slice(int(e) - n, int(e)) for e, n in zip(ends, lengths, strict=True)]
    whiten = fit_whitener(residuals[best], np.ones_like(residuals[best]), slices, ["" for _ in slices])
    index = block_index(lengths, steps_s)
    charge = 0.5 * float(np.log(max(len(index), 2)))
    found = [block_scores(whiten(r), index) for r in residuals]
    return [Score(float(b.sum()) - charge * k, b) for b, k in zip(found, parameters, strict=True)]
