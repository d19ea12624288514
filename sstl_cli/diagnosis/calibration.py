"""How often each kind of verdict was right on a library of rig recordings kept apart from every blind set."""

from __future__ import annotations

import json
from functools import cache
from importlib import resources
from typing import Any

FILE = "calibration.json"


@cache
def packaged() -> dict[str, Any] | None:
    """Return the calibration of the package, None where it was never calibrated."""
    path = resources.files("sstl_cli.diagnosis") / FILE
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None


def temperature(default: float) -> float:
    """Return the scale that turns differences of scores (nats) into probabilities."""
    known = packaged()
    return default if known is None else float(known["temperature"])


def confidence(evidence: str, stated: float) -> float:
    """Return the share of right verdicts among those of the same kind of evidence; ``stated`` where the library had none."""
    known = packaged()
    verdicts = {} if known is None else known.get("verdicts", {})
    return float(verdicts[evidence]["right"]) if evidence in verdicts else stated
