"""Identify, compensate and diagnose tendon-sheath hysteresis from recorded tension logs.

The names below are the public face for Python; the program ``sstl`` runs the same functions. They are loaded when first
used, so that importing the package costs next to nothing.

Examples
--------
>>> import sstl_cli as sstl
>>> log = sstl.simulate("two-tendons", seed=1)
>>> log
Log(12 runs, 48000 samples)
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from sstl_cli.core.kept import at_start as _ensure
from sstl_cli.core.kept import fonts_beside as _fonts

if TYPE_CHECKING:
    from sstl_cli.api.blinded import (
        BlindInjectDocument,
        BlindLearnDocument,
        BlindLibraryDocument,
        BlindLimitDocument,
        BlindMakeDocument,
        BlindRealDocument,
        BlindRunDocument,
        BlindScoreDocument,
        BlindSet,
        blind_inject,
        blind_learn,
        blind_library,
        blind_real,
    )
    from sstl_cli.api.catalogue import effects
    from sstl_cli.api.control import Biases, Controller, ControllerOptions, compensate, controller
    from sstl_cli.api.diagnosis import Diagnosis, diagnose
    from sstl_cli.api.exporting import Controllers, controllers
    from sstl_cli.api.installed import DoctorDocument, doctor, schema
    from sstl_cli.api.log import Log, Scenario, read, simulate
    from sstl_cli.api.mapping import Mapping, relate, train
    from sstl_cli.api.planning import PlanDocument, StagesDocument, plan, stages
    from sstl_cli.api.recordings import Guess, guess, import_
    from sstl_cli.api.reproducing import ReproduceDocument, Reproduction, measure_spread, reproduce
    from sstl_cli.api.watching import AlarmDocument, LoopDocument, WatchDocument, watch
    from sstl_cli.core.errors import SstlError

__version__ = "0.2.0"

__all__ = [
    "AlarmDocument", "Biases", "BlindInjectDocument", "BlindLearnDocument", "BlindLibraryDocument", "BlindLimitDocument",
    "BlindMakeDocument", "BlindRealDocument", "BlindRunDocument", "BlindScoreDocument", "BlindSet", "Controller", "ControllerOptions",
    "Controllers", "Diagnosis", "DoctorDocument", "Guess", "Log", "LoopDocument", "Mapping", "PlanDocument", "ReproduceDocument",
    "Reproduction", "Scenario", "SstlError", "StagesDocument", "WatchDocument", "blind_inject", "blind_learn", "blind_library",
    "blind_real", "compensate", "controller", "controllers", "diagnose", "doctor", "effects", "guess", "import_", "measure_spread",
    "plan", "read", "relate", "reproduce", "schema", "simulate", "stages", "train", "watch",
]  # fmt: skip

_HOMES = {
    "BlindInjectDocument": "sstl_cli.api.blinded",
    "BlindLearnDocument": "sstl_cli.api.blinded",
    "BlindLibraryDocument": "sstl_cli.api.blinded",
    "BlindLimitDocument": "sstl_cli.api.blinded",
    "BlindMakeDocument": "sstl_cli.api.blinded",
    "BlindRealDocument": "sstl_cli.api.blinded",
    "BlindRunDocument": "sstl_cli.api.blinded",
    "BlindScoreDocument": "sstl_cli.api.blinded",
    "BlindSet": "sstl_cli.api.blinded",
    "blind_inject": "sstl_cli.api.blinded",
    "blind_learn": "sstl_cli.api.blinded",
    "blind_library": "sstl_cli.api.blinded",
    "blind_real": "sstl_cli.api.blinded",
    "Biases": "sstl_cli.api.control",
    "Controller": "sstl_cli.api.control",
    "ControllerOptions": "sstl_cli.api.control",
    "compensate": "sstl_cli.api.control",
    "controller": "sstl_cli.api.control",
    "Controllers": "sstl_cli.api.exporting",
    "controllers": "sstl_cli.api.exporting",
    "DoctorDocument": "sstl_cli.api.installed",
    "doctor": "sstl_cli.api.installed",
    "schema": "sstl_cli.api.installed",
    "effects": "sstl_cli.api.catalogue",
    "Guess": "sstl_cli.api.recordings",
    "guess": "sstl_cli.api.recordings",
    "import_": "sstl_cli.api.recordings",
    "Diagnosis": "sstl_cli.api.diagnosis",
    "diagnose": "sstl_cli.api.diagnosis",
    "Log": "sstl_cli.api.log",
    "Scenario": "sstl_cli.api.log",
    "read": "sstl_cli.api.log",
    "simulate": "sstl_cli.api.log",
    "Mapping": "sstl_cli.api.mapping",
    "relate": "sstl_cli.api.mapping",
    "train": "sstl_cli.api.mapping",
    "PlanDocument": "sstl_cli.api.planning",
    "StagesDocument": "sstl_cli.api.planning",
    "plan": "sstl_cli.api.planning",
    "stages": "sstl_cli.api.planning",
    "ReproduceDocument": "sstl_cli.api.reproducing",
    "Reproduction": "sstl_cli.api.reproducing",
    "measure_spread": "sstl_cli.api.reproducing",
    "reproduce": "sstl_cli.api.reproducing",
    "AlarmDocument": "sstl_cli.api.watching",
    "LoopDocument": "sstl_cli.api.watching",
    "WatchDocument": "sstl_cli.api.watching",
    "watch": "sstl_cli.api.watching",
    "SstlError": "sstl_cli.core.errors",
}

# before anything imports numba or matplotlib
_ensure()


def __getattr__(name: str) -> Any:
    """Load a public name when it is first asked for (PEP 562)."""
    if name not in _HOMES:
        raise AttributeError(f"module 'sstl_cli' has no attribute '{name}'; public names: {', '.join(__all__)}")
    _fonts()
    value = getattr(importlib.import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
