"""Write the sample recordings of docs/tutorial.md as a lab would have them: a file each, own names, own units.

``python tools/bench_files.py LOG.parquet FOLDER`` turns every run of a log into FOLDER/bendCONFIG_MOVEMENT_SYSTEM.csv
with time in ms and tensions in lbf.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from sstl_cli.core.runs import read_runs
from sstl_cli.core.units import unit_of

HEADER = "t (ms),F_motor (lbf),F_far (lbf)"


def main(log: Path, folder: Path) -> None:
    """Write one CSV file a run."""
    _, lbf = unit_of("lbf")
    folder.mkdir(parents=True, exist_ok=True)
    for run in read_runs(log):
        columns = (run.time_s * 1000.0, run.tension_in_n / lbf, run.tension_out_n / lbf)
        name = f"bend{run.config_id}_{run.trajectory}_{run.system}.csv"
        np.savetxt(folder / name, np.column_stack(columns), fmt=("%.0f", "%.4f", "%.4f"), delimiter=",", header=HEADER, comments="")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
