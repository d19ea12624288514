"""Build the site of the documents: ``make docs`` gives build/site/index.html; a broken link is an error.

The documents are plain Markdown that any forge shows. For the site they are copied together with README, CONTRIBUTING and
CHANGELOG, links between them are set to the copies, and the table of index.md becomes the order of the pages.
"""

from __future__ import annotations

import re
import shutil
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BESIDE = {"README.md": "readme.md", "CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md"}


def gather(folder: Path) -> None:
    """Copy all documents into a folder, with links that hold there."""
    if folder.exists():
        shutil.rmtree(folder)
    folder.mkdir(parents=True)
    for path in sorted((ROOT / "docs").iterdir()):
        if path.suffix == ".md":
            (folder / path.name).write_text(inside(path.read_text(encoding="utf-8")), encoding="utf-8")
        elif path.suffix in (".py", ".svg", ".ipynb", ".txt"):
            shutil.copy(path, folder / path.name)
    for name, copy in BESIDE.items():
        (folder / copy).write_text(inside((ROOT / name).read_text(encoding="utf-8")), encoding="utf-8")
    index = (folder / "index.md").read_text(encoding="utf-8")
    pages = [n.removesuffix(".md") for n in re.findall(r"^\| \[[^\]]*\]\(([\w-]+\.md)\)", index, re.M)]
    tree = "\n".join([*pages, "readme", "contributing", "changelog"])
    (folder / "index.md").write_text(f"{index}\n```{{toctree}}\n:hidden:\n:maxdepth: 1\n\n{tree}\n```\n", encoding="utf-8")


def inside(text: str) -> str:
    """Return a document with its links set to the copies.

    Examples
    --------
    >>> inside("[a](../README.md), [b](docs/import.md#x), [c](loop.svg)")
    '[a](readme.md), [b](import.md#x), [c](loop.svg)'
    """

    def moved(match: re.Match[str]) -> str:
        target = match[1].removeprefix("../").removeprefix("docs/")
        name, mark, place = target.partition("#")
        return f"]({BESIDE.get(name, name)}{mark}{place})"

    return re.sub(r"\]\((?!https?:)([^)\s]+)\)", moved, text)


def main() -> int:
    """Gather and build; the number of warnings decides."""
    from sphinx.cmd.build import build_main

    source, out = ROOT / "build" / "site-source", ROOT / "build" / "site"
    gather(source)
    return build_main(["-q", "-W", "--keep-going", "-b", "html", "-d", str(ROOT / "build" / "site-cache"), str(source), str(out)])


if __name__ == "__main__":
    sys.exit(main())
