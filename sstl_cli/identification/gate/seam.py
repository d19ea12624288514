"""Where one recording ends and another goes on: both channels jump at one sample, and stay there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sstl_cli.identification.filtering import median

Array = NDArray[np.float64]
# smallest jump looked at (share of the span), and samples on either side that it is compared with
LEAST_JUMP, AROUND = 0.05, 40
# part of a jump that a channel must make at one renewal of its own, and of the largest jump that makes another one; more jumps than that are a movement
AT_ONCE, ANOTHER, MOST = 0.7, 0.5, 2
# part of the input's jump from which on others of the input make it a movement in steps
STEPS = 0.25
# part of the input's way that a movement in steps jumps: a sawtooth half, a staircase all; and means over which the way is measured
JUMPED, BLOCKS = 0.35, 256
# joints of blocks in another order, part of both spans to which the end of one must be the beginning of another, and part of the way that may be jumps
LEAST_JOINTS, MOST_JOINTS, MEETS, MOVES = 3, 8, 0.04, 0.6
# largest steps of a channel looked at
MOST_JUMPS = 256
# largest step of a channel anywhere else beyond which a jump is no movement of it, whatever the level
ALONE = 5.0
# sampling periods from which on rows are missing
LONG = 2.5


def seam_of(
    time_s: Array, channels: tuple[Array, Array], spans: tuple[float, float], strides: tuple[int, int] = (1, 1)
) -> tuple[tuple[float, float], float]:
    """Return the largest jump that both channels make at one sample for good (shares of their spans), and when (s).

    A jump is the change of the median of five samples beyond what five of the largest steps around it would make. Of
    channels held for some samples (``strides``) one of each is looked at, and one may jump a renewal later than the other.
    A movement in steps jumps again and again, and goes most of its way so: there is no seam in it. Several recordings in one run
    jump as well, but go their way between the jumps.
    """
    stride = max(strides)
    few = [c[::stride] for c in channels]
    # a quiet input rests on one level of its converter as well; only a recorder holds both channels
    stood = _repeats(few[0]) & _repeats(few[1])
    jumps = [_jumps(c, span, stood) for c, span in zip(few, spans, strict=True)]
    if stride > 1:
        jumps = [np.maximum(j, np.maximum(np.append(j[1:], 0.0), np.insert(j[:-1], 0, 0.0))) for j in jumps]
    both = np.minimum(*jumps)
    # where rows are missing both channels go on meanwhile
    step = np.diff(time_s[::stride])
    both = np.where(step > LONG * median(step), 0.0, both)
    k = int(np.argmax(both))
    again = np.flatnonzero(both > ANOTHER * both[k])
    # or of the input alone, where the output rests
    steps = np.flatnonzero(jumps[0] > STEPS * jumps[0][k])
    many = both[k] > 0.0 and max(1 + np.count_nonzero(np.diff(a) > 2) for a in (again, steps)) > MOST
    many &= float(np.sum(jumps[0])) * spans[0] > JUMPED * way_of(few[0]) and not _reordered(few, spans, both)
    # a ramp between two renewals of the slower channel is no jump of the other one
    gradual = any(
        not _at_once(c, k * stride, stride, s, AT_ONCE * float(j[k]) * span)
        for c, span, s, j in zip(channels, spans, strides, jumps, strict=True)
        if s < stride
    )
    if many or gradual:
        return (0.0, 0.0), float(time_s[::stride][k + 1])
    return (float(jumps[0][k]), float(jumps[1][k])), float(time_s[::stride][k + 1])


def _reordered(channels: list[Array], spans: tuple[float, float], both: Array) -> bool:
    """Whether the pieces between the jumps of both channels are those of one movement in another order: each begins where another one ends.

    A movement in steps begins where it ended, too, but hardly moves between its jumps.
    """
    at = np.flatnonzero(both > 0.0)
    if not len(at):
        return False
    # a jump of held channels is seen at a renewal or two
    joints = [group[int(np.argmax(both[group]))] for group in np.split(at, 1 + np.flatnonzero(np.diff(at) > 2))]
    if not LEAST_JOINTS <= len(joints) <= MOST_JOINTS:
        return False
    ends, begins = (
        np.array([[median(c[max(0, k + low) : k + high]) / max(s, 1e-300) for c, s in zip(channels, spans, strict=True)] for k in joints])
        for low, high in ((-2, 1), (1, 4))
    )
    off = np.max(np.abs(begins[:, None, :] - ends[None, :, :]), axis=2)
    # the joint itself is a jump
    off[np.arange(len(joints)), np.arange(len(joints))] = np.inf
    nearest = np.argmin(off, axis=1)
    jumped = float(np.sum(np.abs(begins - ends)[:, 0])) * spans[0]
    moves = jumped < MOVES * way_of(channels[0])
    return moves and len(set(nearest.tolist())) == len(joints) and bool(np.all(off.min(axis=1) < MEETS))


def alone_at(
    time_s: Array, channels: tuple[Array, Array], seam: tuple[float, float], at_s: float, strides: tuple[int, int] = (1, 1)
) -> bool:
    """Return whether what both channels jump by at a seam (N, beyond the steps around it) is like nothing else in the run.

    It is beyond any of their steps elsewhere, noise among them, and a small part of the way that the input goes by itself: a drive that can jump
    so does it more than once, or does little else.
    """
    stride = max(strides)
    k = int(np.searchsorted(time_s[::stride], at_s)) - 1
    for c, jump in zip(channels, seam, strict=True):
        step = np.abs(np.diff(c[::stride]))
        step[max(0, k - 1) : k + 2] = 0.0
        if not jump > ALONE * float(step.max(initial=0.0)):
            return False
    return seam[0] < JUMPED * way_of(channels[0][::stride])


def way_of(v: Array) -> float:
    """Return how far a channel goes to and fro, noise left out."""
    block = -(-len(v) // BLOCKS)
    means = v[: len(v) // block * block].reshape(-1, block).mean(axis=1)
    return float(np.sum(np.abs(np.diff(means))))


def _repeats(v: Array) -> NDArray[np.bool_]:
    """Return for each step from one sample to the next whether the four samples before it are one value."""
    same = np.diff(v, prepend=np.nan) == 0.0
    found = np.zeros(max(0, len(v) - 1), np.bool_)
    found[3:] = (same[1:-3] & same[2:-2] & same[3:-1])[: len(found) - 3]
    return found


def _jumps(v: Array, span: float, stood: NDArray[np.bool_]) -> Array:
    """Return how far a channel jumps for good after each sample (shares of its span), but where the recorder ``stood`` still."""
    step = np.abs(np.diff(v))
    lasting = np.zeros(len(step))
    at = np.flatnonzero(step > LEAST_JUMP * span)
    if len(at) > MOST_JUMPS:
        at = at[np.argsort(step[at])[-MOST_JUMPS:]]
    for k in at[(at >= 4) & (at < len(v) - 5)]:
        if stood[k]:
            # it catches up
            continue
        usual = max(float(s.max(initial=0.0)) for s in (step[max(0, k - AROUND) : k - 1], step[k + 2 : k + AROUND]))
        lasting[k] = abs(median(v[k + 1 : k + 6]) - median(v[k - 4 : k + 1])) - 5.0 * usual
    return lasting / max(span, 1e-300)


def _at_once(v: Array, at: int, around: int, stride: int, size: float) -> bool:
    """Whether a channel jumps by ``size`` within one renewal of its own near a sample."""
    near = v[max(0, at - around) : at + 2 * around + stride]
    return len(near) > stride and bool(np.max(np.abs(near[stride:] - near[:-stride])) > size)
