"""Write the JSON Schemas of all documents to docs/schemas, one file each; ``python tools/schemas.py``."""

from __future__ import annotations

import json
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
FOLDER = ROOT / "docs" / "schemas"


def texts() -> dict[str, str]:
    """Return the text of every schema by its file name."""
    from sstl_cli.core.documents import catalogue

    return {f"{name}.json": json.dumps(m.json_schema(), indent=1, sort_keys=True) + "\n" for name, m in catalogue().items()}


def main() -> None:
    """Write what changed, and remove what is no document any more."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    made = texts()
    for path in FOLDER.glob("*.json"):
        if path.name not in made:
            path.unlink()
    for name, text in made.items():
        (FOLDER / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
