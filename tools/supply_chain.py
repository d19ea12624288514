"""What the program is built on: hashes, licences, bill of materials and sizes.

``python tools/supply_chain.py`` writes docs/supply.md and build/sbom.json from what is installed. ``--check`` writes nothing:
it ends with 1 if packages contradict each other, differ from constraints.txt, lack a hash, or come with a licence that a
program under MIT must not ship. ``--hashes`` asks the package index for the hashes again (hashes.txt).
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tempfile
import tomllib
from collections import Counter
from importlib import metadata
from pathlib import Path
from typing import Any

from packaging.requirements import Requirement
from page_part import DOCS, table

ROOT = Path(__file__).resolve().parents[1]
CONSTRAINTS, HASHES = ROOT / "constraints.txt", ROOT / "hashes.txt"
PYTHONS = ("3.11", "3.12", "3.13")
SHIPPED_EXTRAS = ("robot", "onnx", "cluster")
# strong copyleft would reach the whole program; LGPL and MPL do not through an import
REFUSED = re.compile(r"\b(A?GPL|GNU (Affero )?General Public)", re.IGNORECASE)
# the index has torch with CUDA only, and the CPU wheel of Python 3.11 stands for what is tested
ONLY_311 = ("torch",)


def plain(name: str) -> str:
    """Return a package name as the index normalises it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def pinned() -> dict[str, str]:
    """Return the versions in constraints.txt."""
    lines = (line.split("#")[0].split(";")[0].strip() for line in CONSTRAINTS.read_text(encoding="utf-8").splitlines())
    return {plain(n): v for n, _, v in (line.partition("==") for line in lines if "==" in line)}


def hashed() -> dict[str, str]:
    """Return the versions in hashes.txt that have at least one hash."""
    text = HASHES.read_text(encoding="utf-8").replace("\\\n", " ")
    return {plain(m[1]): m[2] for m in re.finditer(r"^(\S+)==(\S+)\s.*--hash=sha256:[0-9a-f]{64}", text, re.MULTILINE)}


def shipped() -> dict[str, metadata.Distribution]:
    """Return every installed package that the program needs, its extras for users included."""
    found: dict[str, metadata.Distribution] = {}
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    todo = [*project["dependencies"], *(r for e in SHIPPED_EXTRAS for r in project["optional-dependencies"][e])]
    while todo:
        requirement = Requirement(todo.pop())
        name = plain(requirement.name)
        if name in found or (requirement.marker and not requirement.marker.evaluate({"extra": ""})):
            continue
        try:
            found[name] = metadata.distribution(name)
        except metadata.PackageNotFoundError:
            # `pip check` tells
            continue
        todo += found[name].requires or []
    return dict(sorted(found.items()))


def licence(package: metadata.Distribution) -> str:
    """Return the licence a package states: its SPDX expression, its classifiers, or the first line of its text."""
    about = package.metadata
    if "License-Expression" in about:
        return str(about["License-Expression"])
    classifiers = [c.split(" :: ")[-1] for c in about.get_all("Classifier") or [] if c.startswith("License ::")]
    named = [c for c in classifiers if c != "OSI Approved"]
    text = "".join(about.get_all("License") or []).strip().splitlines()
    return " / ".join(named) if named else text[0][:60] if text else "not stated"


def size_mb(package: metadata.Distribution) -> float:
    """Return the size of a package's installed files."""
    files = (Path(str(package.locate_file(f))) for f in package.files or [])
    return sum(f.stat().st_size for f in files if f.is_file()) / 1e6


def problems() -> list[str]:
    """Return what is wrong, in words."""
    found = []
    done = subprocess.run([sys.executable, "-m", "pip", "check"], capture_output=True, text=True, check=False)
    if done.returncode:
        found += done.stdout.strip().splitlines()
    pins, sums = pinned(), hashed()
    for name, package in shipped().items():
        version = package.version.split("+")[0]
        if name not in pins:
            found.append(f"{name} is needed, but not pinned in constraints.txt")
        elif pins[name].split("+")[0] != version:
            found.append(f"{name} {version} is installed, {pins[name]} is pinned")
        if sums.get(name, "").split("+")[0] != pins.get(name, "").split("+")[0]:
            found.append(f"{name} has no hash for its pinned version in hashes.txt")
        if REFUSED.search(licence(package)) and "LGPL" not in licence(package):
            found.append(f"{name} is under {licence(package)}")
    return found


def write_hashes() -> None:
    """Ask the index what it would install for each Python on Linux x86-64, and keep the hashes."""
    sums: dict[str, set[str]] = {}
    versions: dict[str, str] = {}
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = [*project["dependencies"], *(r for e in SHIPPED_EXTRAS for r in project["optional-dependencies"][e])]
    for python in PYTHONS:
        packages = [r for r in wanted if python == "3.11" or not r.startswith(ONLY_311)]
        with tempfile.TemporaryDirectory() as folder:
            report = Path(folder) / "report.json"
            words = ["install", "--dry-run", "--quiet", "--ignore-installed", "--only-binary=:all:", "--target", folder]
            words += ["--python-version", python, "--report", str(report), "-c", str(CONSTRAINTS), *packages]
            subprocess.run([sys.executable, "-m", "pip", *words], check=True)
            for item in json.loads(report.read_text(encoding="utf-8"))["install"]:
                name = plain(item["metadata"]["name"])
                versions[name] = item["metadata"]["version"].split("+")[0]
                sums.setdefault(name, set()).add(item["download_info"]["archive_info"]["hashes"]["sha256"])
    lines = [HEAD.strip()]
    for name in sorted(sums):
        lines.append(" \\\n".join([f"{name}=={versions[name]}", *(f"    --hash=sha256:{s}" for s in sorted(sums[name]))]))
    HASHES.write_text("\n".join(lines) + "\n", encoding="utf-8")


HEAD = """
# Hashes of every package that the program needs: wheels for Linux x86-64, Python 3.11 to 3.13 (torch: the CPU wheel of 3.11).
# Made from constraints.txt by `python tools/supply_chain.py --hashes`. pip cannot check hashes of an editable project, so:
#   pip install --require-hashes -r hashes.txt && pip install --no-deps .
"""


def write_sbom(path: Path) -> None:
    """Write a CycloneDX bill of materials of the whole environment."""
    path.parent.mkdir(parents=True, exist_ok=True)
    words = ["environment", "--output-reproducible", "--of", "JSON", "-o", str(path), sys.executable]
    subprocess.run([str(Path(sys.executable).parent / "cyclonedx-py"), *words], check=True)


def page() -> str:
    """Return docs/supply.md."""
    packages = shipped()
    sizes = {name: size_mb(p) for name, p in packages.items()}
    everything = {plain(str(d.metadata["Name"])): size_mb(d) for d in metadata.distributions()}
    rows: list[list[Any]] = [[n, p.version, licence(p), f"{sizes[n]:.1f}"] for n, p in packages.items()]
    kinds = Counter(licence(p) for p in packages.values())
    return PAGE.format(
        packages=len(packages), whole=sum(sizes.values()), all_packages=len(everything), everything=sum(everything.values()),
        torch=sizes["torch"], kinds=", ".join(f"{k} ({n})" for k, n in kinds.most_common(6)),
        table=table(["package", "version", "licence as stated", "MB"], rows),
    )  # fmt: skip


PAGE = """# What the program is built on

`constraints.txt` pins every package, `hashes.txt` has the SHA-256 of each wheel that the program needs (Linux x86-64, Python 3.11
to 3.13; of torch the CPU wheel of 3.11 alone). pip cannot check hashes of an editable project, which `make install` makes; who wants every byte checked installs by

    pip install --require-hashes -r hashes.txt && pip install --no-deps .

CI runs `pip check` and compares installed versions, pins, hashes and licences (`tools/supply_chain.py --check`, called by
`tests/trust/test_trust_supply.py`); `make sbom` writes this page and a CycloneDX bill of materials, `build/sbom.json`. No
package is under the GPL or AGPL. Most frequent: {kinds}.

Installed, the program and its extras for users take {whole:.0f} MB in {packages} packages, {torch:.0f} MB of them torch (CPU); with the
tools for developers it is {everything:.0f} MB in {all_packages} packages.

{table}
"""


def main() -> int:
    """Check, or write; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])  # type: ignore[union-attr]
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--hashes", action="store_true")
    given = parser.parse_args()
    if given.hashes:
        write_hashes()
    if not given.check:
        (DOCS / "supply.md").write_text(page(), encoding="utf-8")
        write_sbom(ROOT / "build" / "sbom.json")
    found = problems()
    for line in found:
        print(line, file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
