"""From the readings of a sensor to the grid of the simulation: bridged, averaged, smoothed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sstl_cli.diagnosis.latent import NOTHING, Latent, Slow, Told, block_mean, latent
from sstl_cli.diagnosis.recorder import slow_noise, white_beside, white_noise

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


def bridged(signal: Array, good: Mask) -> Array:
    """Return a signal with straight lines in the place of samples that are not good."""
    if good.all():
        return signal
    at = np.arange(len(signal))
    return np.interp(at, at[good], signal[good])


def of_readings(signal: Array, fine: Array, good: Mask, fresh: Mask, thin: int, factor: int) -> tuple[Array, Array, Array]:
    """Return the mean reading of each block, of how many it is, and the share of each step of the simulation in it.

    Parameters
    ----------
    signal, good, fresh : ndarray, shape (n * thin or a little more,)
        What was recorded, where it is sound, and where it is a reading of its own.
    fine : ndarray, shape (n,)
        Its means on the grid of the simulation.
    """
    n = len(fine)
    read = good & fresh
    # what is bridged, over a gap or a fault, is no reading of the blocks at its ends
    if read[: n * thin].all():
        return block_mean(fine, factor), np.full(n // factor, float(factor)), np.full(n, 1.0 / factor)
    count = block_mean(read[: n * thin].astype(float), thin) * thin
    readings = block_mean(count, factor) * factor
    total = block_mean((signal * read)[: n * thin], thin * factor) * thin * factor
    share = np.where(np.repeat(readings, factor) > 0.0, count / np.maximum(np.repeat(readings, factor), 1.0), 1.0 / factor)
    means = np.where(readings > 0.0, total / np.maximum(readings, 1.0), block_mean(fine, factor))
    # of a slow sensor a step of the simulation holds one reading at most; of others it is the mean of several that counts as one
    return means, np.maximum(readings / thin if fresh.all() else readings, 1.0), share


def latent_means(
    signal: Array, known: Mask, fresh: Mask, rounding_n: float, thin: int, n: int, dt_s: float, told: Told = NOTHING
) -> Latent:
    """Return the latent signal on the grid of the simulation (block means of ``thin`` samples)."""
    means, white, use = readings_of(signal, known, fresh, rounding_n, thin, n, dt_s, told.slow)
    return latent(means, dt_s, white, use, told)


def readings_of(
    signal: Array, known: Mask, fresh: Mask, rounding_n: float, thin: int, n: int, dt_s: float, slow: Slow
) -> tuple[Array, float, Mask]:
    """Return block means of ``thin`` samples, their white noise (N) beside slow noise, and which of them are known.

    Of a slow sensor a block holds one reading at most: its noise is that of one.
    """
    share, means = block_mean((known & fresh).astype(float), thin)[:n], block_mean(signal, thin)[:n]
    if fresh.all():
        return means, white_of(signal, known, rounding_n, dt_s / thin, slow) / float(np.sqrt(thin)), share > 0.5
    at = np.flatnonzero(fresh)
    kept = slow.kept(float(np.median(np.diff(at))) * dt_s / thin)
    white = max(white_beside(slow_noise(signal[fresh], at.astype(float)), slow.sd_n, kept), rounding_n)
    return means, white, share > 0.0


def unread_n(out: Latent, read: Mask, at: int) -> float:
    """Return the standard deviation (N) of a smoothed output at a step, beside what it may have done before it was read.

    A slow sensor tells nothing until it is renewed for the first time, and the line may have come round a corner since. It is taken
    to have moved before as far as it does in as long a time after.

    Parameters
    ----------
    read : ndarray of bool, shape (n,)
        Steps that hold a reading.
    """
    error, ahead = float(np.sqrt(out.variance[at])), int(np.argmax(read[at:])) if read[at:].any() else 0
    if ahead == 0 or read[max(at - ahead, 0) : at].any():
        return error
    first, later = at + ahead, min(at + 2 * ahead, len(read) - 1)
    return float(np.hypot(error, out.value[later] - out.value[first]))


def white_of(signal: Array, known: Mask, rounding_n: float, dt_s: float, slow: Slow) -> float:
    """Return the white noise (N) of equally spaced readings beside slow noise, at least that of their rounding."""
    return max(white_beside(white_noise(signal, known), slow.sd_n, slow.kept(dt_s)), rounding_n)
