"""What is left of a channel once its movement is taken off: the noise of a sensor, or the rounding of the digits of a number that was computed.

A sensor has noise in every difference of its readings. Of a movement that is computed each higher difference leaves less,
down to the rounding of its digits.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sstl_cli.identification import filtering

Array = NDArray[np.float64]
# orders of differences: those of white noise are alike, of a movement of 1 Hz sampled at 100 Hz a third from one to the next
ORDERS = range(2, 9)
# most digits behind the decimal point that are asked about
DIGITS = 9
# samples that show it, and the fewest that do; part of its changes by which a ramp goes on evenly
ENOUGH, MIN_SAMPLES, EVEN = 4096, 32, 0.9


def digit_of(values: Array) -> float:
    """Return the last digit (N) that the values are written with: a power of ten, or that of single or double precision.

    Examples
    --------
    >>> digit_of(np.array([1.25, 3.5, 2.0]))
    0.01
    """
    for digits in range(DIGITS + 1):
        scaled = values * 10.0**digits
        # what a text is read to is off by half a last place, its product by another
        if bool(np.all(np.abs(scaled - np.round(scaled)) <= 2.0 * np.spacing(np.abs(scaled)))):
            return 10.0**-digits
    largest = float(np.max(np.abs(values)))
    single = np.float32(largest)
    return float(np.spacing(single)) if bool(np.all(values.astype(np.float32) == values)) else float(np.spacing(largest))


def left_of_movement(values: Array) -> float:
    """Return the least spread (N) that differences of any order leave, as that of white noise."""
    found = math.inf
    difference = np.diff(values)
    for order in ORDERS:
        difference = np.diff(difference)
        if len(difference) < 2:
            break
        found = min(found, filtering.white_of(difference, order))
    return found


def rounding_of(values: Array) -> float:
    """Return the last digit (N) of a channel beside whose movement nothing but its rounding is left, numbers of a program; 0 for readings."""
    if len(values) < MIN_SAMPLES:
        return 0.0
    few = values[:ENOUGH]
    digit = digit_of(few)
    return digit if left_of_movement(few) < digit else 0.0


def ramps(values: Array) -> bool:
    """Return whether changes are followed by the same one but for rounding; those between the levels of a converter are rests and steps by turns.

    A ramp that is computed and comes back to its own numbers takes levels as well.
    """
    digit = digit_of(values[:ENOUGH])
    change = np.diff(values)
    moves = np.abs(change[:-1]) > digit
    # three roundings are in a second difference, of half a digit each and twice that
    return bool(moves.any()) and float(np.mean(np.abs(np.diff(change))[moves] <= 2.0 * digit)) > EVEN
