"""What the program is built on agrees with what is written about it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
TOOLS = ROOT / "tools"
sys.path.insert(0, str(TOOLS))

import supply_chain  # noqa: E402


def test_packages_pins_hashes_and_licences_agree() -> None:
    done = subprocess.run([sys.executable, TOOLS / "supply_chain.py", "--check"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_a_wrong_pin_and_a_missing_hash_are_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pins, sums = tmp_path / "c.txt", tmp_path / "h.txt"
    pins.write_text(supply_chain.CONSTRAINTS.read_text().replace("numpy==", "numpy==0."))
    sums.write_text(supply_chain.HASHES.read_text().replace("scipy==", "scipi=="))
    monkeypatch.setattr(supply_chain, "CONSTRAINTS", pins)
    monkeypatch.setattr(supply_chain, "HASHES", sums)
    found = " ".join(supply_chain.problems())
    assert "numpy" in found and "scipy has no hash" in found


def test_every_package_is_on_the_page() -> None:
    page = (ROOT / "docs" / "supply.md").read_text(encoding="utf-8")
    pins = supply_chain.pinned()
    for name in supply_chain.shipped():
        assert f"| {name} | {pins[name]}" in page, f"{name}: run `make sbom`"


@pytest.mark.parametrize(("text", "bad"), [("GPL-3.0-only", True), ("GNU Affero General Public License v3", True), ("MIT", False)])
def test_licences_that_must_not_be_shipped(text: str, bad: bool) -> None:
    assert bool(supply_chain.REFUSED.search(text)) == bad
