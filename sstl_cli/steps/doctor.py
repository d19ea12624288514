"""What this installation is made of, and a self-test that plants known lines and finds them again."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import platform
import time

import numpy as np

from sstl_cli import __version__
from sstl_cli.core.config import parse
from sstl_cli.core.documents.outputs import DoctorDocument, ProbePart
from sstl_cli.core.kept import Kept, at_start
from sstl_cli.core.tables import PARAMETERS
from sstl_cli.identification import SegmentOptions
from sstl_cli.physics.scenario import Scenario
from sstl_cli.steps import segment, simulate

PACKAGES = (
    "numpy", "scipy", "pandas", "pyarrow", "numba", "scikit-learn", "torch", "pydantic", "safetensors", "typer", "rich",
    "matplotlib", "jinja2", "joblib", "fsspec", "h5py", "npTDMS",
)  # fmt: skip
EXTRAS = {"robot": ("mcap", "rosbags"), "onnx": ("onnx", "onnxruntime"), "cluster": ("distributed",)}
PLANTED = {"gamma_p": 0.6, "beta_p": 0.3, "gamma_r": 1.6, "beta_r": -0.2}
TOLERANCE = {"gamma_p": 0.02, "beta_p": 0.1, "gamma_r": 0.05, "beta_r": 0.2}


def run() -> DoctorDocument:
    """Return what is installed, and the probes of it."""
    versions = {name: _version(name) for name in PACKAGES}
    extras = {name: all(_version(p) is not None for p in needed) for name, needed in EXTRAS.items()}
    missing = [name for name, version in versions.items() if version is None]
    told = f"missing: {', '.join(missing)}" if missing else f"{len(versions)} found"
    probes = [_probe("packages", not missing, told, "pip install sstl-cli"), cache_probe(at_start()), self_test()]
    return DoctorDocument(
        schema="sstl.doctor/1",
        ok=all(p.ok for p in probes),
        sstl=__version__,
        python=platform.python_version(),
        system=f"{platform.system()} {platform.machine()}",
        cores=os.cpu_count() or 1,
        cores_usable=len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1,
        packages=versions,
        extras=extras,
        probes=probes,
    )


def cache_probe(kept: Kept) -> ProbePart:
    """Return whether compiled functions are kept where they were asked to be; anywhere else is good enough to work."""
    detail = "; ".join(filter(None, (str(kept.folder or "none"), kept.why)))
    return _probe("compile cache", kept.as_asked, detail, "set NUMBA_CACHE_DIR to a folder that can be written")


def self_test() -> ProbePart:
    """Simulate one bend with known propagation lines, segment it, and compare (both systems, 12 s at 100 Hz)."""
    started = time.monotonic()
    lines = dict(PLANTED)
    scenario = parse(
        Scenario,
        {
            "schema": "sstl.scenario/1",
            "sampling_hz": 100.0,
            "configurations": [{"id": "self-test", "location": "CP", "act": lines}],
            "trajectories": [{"kind": "trapezoid", "duration_s": 12.0, "systems": ["act"]}],
        },
        "self-test",
    )
    runs = list(simulate.run(scenario, {}, 1))
    rows = [found.row() for found in segment.run(runs, SegmentOptions())]
    off = {name: abs(float(value) - PLANTED[name]) for row in rows for name in PARAMETERS if isinstance(value := getattr(row, name), float)}
    good = len(off) == len(PARAMETERS) and all(np.isfinite(d) and d <= TOLERANCE[n] for n, d in off.items())
    shown = ", ".join(f"{n} off by {d:.2g}" for n, d in off.items()) or f"no lines: {rows[0].status}"
    return _probe("self-test", good, f"{shown} ({time.monotonic() - started:.1f} s)", "install again and report it")


def _probe(name: str, ok: bool, detail: str, fix: str) -> ProbePart:
    """Return one check: what was looked at, whether it is good, and what to do where not."""
    return ProbePart(name=name, ok=ok, detail=detail, fix=fix)


def _version(package: str) -> str | None:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None
