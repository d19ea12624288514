"""The diagnosis on recordings made by others; writes docs/real.md.

Takes the folder of recordings (../shared/data), imports each log by its mapping, accepts a model on the first half of every
run, and asks of the second half what has changed: as it is, and with known effects put in (sstl blind real --inject all).
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from sstl_cli.core.documents.blind_real import Injected
from sstl_cli.core.files import write_json, write_text
from sstl_cli.core.provenance import Provenance
from sstl_cli.core.runs import Run, read_runs, write_runs
from sstl_cli.importers.mapping import read_mapping
from sstl_cli.steps import blind_inject
from sstl_cli.steps.import_ import run as import_files

HERE = Path(__file__).resolve().parents[1]
DATA = HERE.parent / "shared" / "data"
IMPORTERS = HERE / "tests" / "importers" / "mappings"
# name of a log, its files, its mapping
LOGS = (
    (
        "band brake, healthy",
        "bandbrake-capstan/dataset-2__0.5Hz0lbtension1amplitude.csv",
        HERE / "tests/diagnosis/mappings/bandbrake-balance.toml",
    ),
    (
        "band brake, faulty sensor",
        "bandbrake-capstan/dataset-2__0.5Hz0lbtension0.5amplitude.csv",
        HERE / "tests/diagnosis/mappings/bandbrake-balance.toml",
    ),
    ("manipulator, straight and bent", "viocom-conf/*.txt", HERE / "tools/real/viocom-conf.toml"),
    ("endoscope, ten bends", "viocom-endoscope/*.txt", IMPORTERS / "viocom-endoscope.toml"),
    ("cylinder KDN", "pneu-cylinder/KDN*.csv", IMPORTERS / "pneu-cylinder.toml"),
    ("cylinder NAPN", "pneu-cylinder/NAPN*.csv", IMPORTERS / "pneu-cylinder.toml"),
)
HEAD = """# Recordings made by others

Made by `make real` from public recordings that come with no part of this program (their folder is `../shared/data`; where each
comes from stands in its README). The model of each rig is accepted on the first half of every run; the second half is then
diagnosed, as it is and with one known effect put in at a time, with the rig's model (what has changed?) and without (what does
the physical base model miss?).

An effect is put in by the textbook's operation on what was recorded (`sstl_cli/blind/inject.py`), not by the model that looks for
it, in a size that moves the output by 7 % of its span (RMS). *Decidable* is what the record itself can tell: at least D^2 = 24
from the model and from the nearest rival.

What is wanted: 80 % of the decidable ones named, wrong commits at most 5 %, untouched halves `none` in 90 %, sizes within 20 %
in 80 % of those named. Beside a large known misfit the answer is careful, and names too little.
A column with a dash was not run. In the two cylinders a motion drives the line; dry friction behind it is there the same
operation on the readings as hysteresis of the sensor: where a sensor may have as much of it the two stand in a set. The estimate is that of
the parameter that was put in, where the data do not put it behind the likeliest (an input's zero and an output's look alike where a line
hardly rubs). The sensor of the faulty band brake reads an eighth, as its authors say: without its model that is what the base lacks, whatever
is put in besides, and a right `gain_error` counts as wrong here.
"""


def imported(pattern: str, mapping: Path, folder: Path) -> list[Run]:
    """Return the runs of a log."""
    path = folder / "log.parquet"
    write_runs(path, import_files(sorted(DATA.glob(pattern)), read_mapping(mapping)).runs, Provenance("real"), force=True)
    return list(read_runs(path))


def page(document: dict) -> str:
    """Return the page."""
    lines = [HEAD, "| score | with the rig's model | without |", "|---|---|---|"]
    scores = [document["with_model"], document["without_model"]]
    for said, k, of in (
        ("effects named", "named", "of"),
        ("in the ambiguity group", "in_group", "of"),
        ("wrong commits", "wrong", "of"),
        ("decidable ones named", "decidable_named", "decidable"),
        ("sizes within 20 %, of those named", "close", "named"),
        ("untouched halves `none`", "untouched_none", "untouched"),
        ("untouched halves with a name", "untouched_named", "untouched"),
    ):
        cells = ["-" if s is None else f"{s[k]} of {s[of]}" for s in scores]
        lines.append(f"| {said} | {cells[0]} | {cells[1]} |")
    lines += ["", "| log | model | put in | size | verdict | named | estimate | decidable |", "|---|---|---|---|---|---|---|---|"]
    for r in document["rows"]:
        estimate = "" if r["estimate"] is None else f"{r['estimate']:.3g}"
        size = "" if r["size"] is None else f"{r.get('size_fitted', r['size']):.3g}"
        named = ", ".join(r["effects"] if r["status"] == "identified" else r["ambiguity_group"][:4]).replace(" | ", " or ")
        told = {True: "yes", False: "no", None: ""}[r["decidable"]]
        lines.append(
            f"| {r['log']} | {'the rig' + chr(39) + 's' if r['with_model'] else 'base'} | {r['effect'] or 'nothing'} | {size} | {r['status']} | {named} | {estimate} | {told} |"
        )
    return "\n".join(lines) + "\n"


def main() -> int:
    """Run what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="folder for results; a log that has one is not run again")
    parser.add_argument("--with-model-only", action="store_true")
    args = parser.parse_args()
    if not DATA.is_dir():
        print(f"the recordings are not at {DATA}", file=sys.stderr)
        return 1
    rows = []
    for i, (name, pattern, mapping) in enumerate(LOGS):
        kept = args.out / f"{i}.json"
        if not kept.exists():
            found = blind_inject.run({name: imported(pattern, mapping, args.out)}, None, without=not args.with_model_only)
            write_json(kept, found.plain(), True)
        rows += [Injected(**row) for row in json.loads(kept.read_text("utf-8"))["rows"]]
        print(f"{name}: done", file=sys.stderr, flush=True)
    whole = blind_inject.scored(rows).plain()
    write_text(HERE / "docs" / "real.md", page(whole), True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
