"""What a user may set of the segmentation; None means derived from the data."""

from __future__ import annotations

from dataclasses import dataclass

from sstl_cli.core.errors import UsageError
from sstl_cli.core.sound import SMALLEST


@dataclass(frozen=True)
class SegmentOptions:
    """Settings of one segmentation; None is derived from sampling rate, noise level and range.

    Parameters
    ----------
    cutoff_hz : float, optional
        Cut-off of the zero-phase Butterworth low-pass.
    prominence_n : float, optional
        How far the filtered input must turn back before it counts as a reversal (N).
    delta_bl_n : float, optional
        Backlash threshold: how far the output must leave its value at the reversal (N).
    ransac_threshold_n : float, optional
        Largest distance of an inlier from its line (N).
    ransac_trials : int
        Pairs of points tried per direction.
    seed : int
        Seed of the RANSAC sampler; each run has its own stream.
    """

    cutoff_hz: float | None = None
    prominence_n: float | None = None
    delta_bl_n: float | None = None
    ransac_threshold_n: float | None = None
    ransac_trials: int = 64
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("cutoff_hz", "prominence_n", "delta_bl_n", "ransac_threshold_n"):
            value = getattr(self, name)
            if value is not None and not SMALLEST <= value < 1e9:
                raise UsageError(f"must be a positive number, not {value:g}", where="--" + name.replace("_", "-"), code="E210")
        if not 1 <= self.ransac_trials <= 100_000:
            raise UsageError(f"must be 1 to 100000, not {self.ransac_trials}", where="--ransac-trials", code="E211")
