"""Filtering, phase segmentation and robust line fits: from a recording to Theta."""

from sstl_cli.identification.labels import PHASE_NAMES, label_phases
from sstl_cli.identification.options import SegmentOptions
from sstl_cli.identification.segment import Segmentation, segment_run

__all__ = ["PHASE_NAMES", "SegmentOptions", "Segmentation", "label_phases", "segment_run"]
