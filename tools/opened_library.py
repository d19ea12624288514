"""A sealed set that has been opened and scored judges nothing any more: its evidence becomes a library to learn from.

python tools/opened_library.py SET LIBRARY    (SET with truth.json and results/; LIBRARY is data/library-N.parquet)

The seeds of the set are then among those that were learned from, so that no later set may have them.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from sstl_cli.blind import kept, seal
from sstl_cli.blind.learning import Example
from sstl_cli.blind.library import case_name, labelled, to_table, write_library
from sstl_cli.core.files import read_json
from sstl_cli.core.provenance import Provenance


def examples_of(folder: Path, truth: seal.Truth) -> list[Example]:
    """Return the cases of a set that have evidence, with the truth that they are learned against."""
    found = []
    for name, case in truth.truths.items():
        result = json.loads((folder / "results" / f"{name}.json").read_text("utf-8"))
        if result["rows"] is not None:
            # a set's names tell nothing; in a library the seed tells a case from those of other sets
            found.append(labelled(case_name(case), case, kept.from_document(result["rows"]).named))
    return found


def main() -> int:
    """Write the library of a set."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("library", type=Path)
    args = parser.parse_args()
    published, closed = (read_json(args.folder / f"{n}.json", s) for n, s in (("hashes", seal.HASHES), ("truth", seal.TRUTH)))
    truth = seal.verify(published, closed, str(args.folder))
    cases = examples_of(args.folder, truth)
    facts = {
        "cases": len(cases),
        "failed": len(truth.truths) - len(cases),
        "simulators": sorted({e.simulator for e in cases}),
        "seeds": [list(truth.seeds)],
        "quick": truth.quick,
        "accepted": False,
    }
    write_library(args.library, to_table(cases), Provenance("opened set", truth.seeds[0], {}, facts))
    print(f"{len(cases)} cases -> {args.library}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
