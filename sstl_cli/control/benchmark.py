"""How long one step takes: inside the Python process, and in the exported C code."""

from __future__ import annotations

import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sstl_cli.control.c_source import c_source
from sstl_cli.control.controller import Controller, Options, Theta
from sstl_cli.control.references import sinusoid
from sstl_cli.core.errors import SstlError

Array = NDArray[np.float64]
TABLE_II = Theta(0.583, -1.444, 1.688, -1.043)
HISTOGRAM_US = (0.0, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, float("inf"))

_DRIVER = """
#include <stdio.h>
#include <time.h>
#include "sstl_controller.h"
int main(void)
{
    sstl_controller c;
    struct timespec a, b;
    sstl_real sum = 0, t_in = 10;
    long k, n = %(n)dL;
    int phase;
    sstl_controller_init(&c);
    clock_gettime(CLOCK_MONOTONIC, &a);
    for (k = 0; k < n; k++) {
        sstl_real t_ref = (sstl_real)(5 + (k %% 20000 < 10000 ? k %% 10000 : 10000 - k %% 10000) * 1e-3);
        t_in = sstl_controller_step(&c, t_ref, t_in, &phase);
        sum += t_in;
    }
    clock_gettime(CLOCK_MONOTONIC, &b);
    fprintf(stderr, "%%g\\n", (double)sum);
    printf("%%.6f\\n", ((double)(b.tv_sec - a.tv_sec) * 1e9 + (double)(b.tv_nsec - a.tv_nsec)) / (double)n);
    return 0;
}
"""


@dataclass(frozen=True)
class Latency:
    """Latency of single steps in microseconds: quantiles, share below 20, counts per histogram bin."""

    median_us: float
    p99_us: float
    p999_us: float
    max_us: float
    below_20_us_pct: float
    edges_us: tuple[float, ...]
    counts: tuple[int, ...]


def python_latency(options: Options | None = None, cycles: int = 2) -> Latency:
    """Return the latency of ``Controller.step`` over the sinusoid, one clock reading around each call."""
    controller = Controller(TABLE_II, options or Options())
    reference = sinusoid(cycles=cycles).tension_n.tolist()
    spent = np.empty(len(reference), np.int64)
    clock, step = time.perf_counter_ns, controller.step
    t_in = controller.rest_tension(reference[0])
    step(reference[0], t_in)
    controller.reset()
    # a loop in Python on purpose: the call from Python is what is measured
    for k, t_ref in enumerate(reference):
        before = clock()
        t_in, _ = step(t_ref, t_in)
        spent[k] = clock() - before
    us = spent / 1000.0
    counts, _ = np.histogram(us, HISTOGRAM_US)
    q = np.percentile(us, (50.0, 99.0, 99.9))
    return Latency(
        float(q[0]),
        float(q[1]),
        float(q[2]),
        float(us.max()),
        float(100.0 * np.mean(us < 20.0)),
        HISTOGRAM_US,
        tuple(int(c) for c in counts),
    )


def c_step_ns(options: Options | None = None, steps: int = 20_000_000, compiler: str = "gcc") -> float:
    """Return the nanoseconds per step of the exported C code in a closed loop, compiled with -O2.

    Raises
    ------
    SstlError
        If there is no such compiler, or it refuses the code.
    """
    code = c_source(Controller(TABLE_II, options or Options()), "benchmark")
    with tempfile.TemporaryDirectory() as folder:
        for name, text in (("sstl_controller.h", code.header), ("sstl_controller.c", code.source)):
            (Path(folder) / name).write_text(text, encoding="utf-8")
        driver = "#define _POSIX_C_SOURCE 199309L\n" + _DRIVER % {"n": steps}
        (Path(folder) / "main.c").write_text(driver, encoding="utf-8")
        command = [compiler, "-std=c99", "-O2", "-o", "bench", "main.c", "sstl_controller.c", "-lm"]
        try:
            subprocess.run(command, cwd=folder, check=True, capture_output=True, timeout=60)
            done = subprocess.run(["./bench"], cwd=folder, check=True, capture_output=True, text=True, timeout=120)
        except (OSError, subprocess.SubprocessError) as error:
            raise SstlError(f"C benchmark failed ({error})", fix="install a C99 compiler", code="E414") from None
    return float(done.stdout)
