"""A new section is one module and one template: found and shown with nothing else changed."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from jinja2 import FileSystemLoader

from sstl_cli.reporting import page as page_module
from sstl_cli.reporting import sections
from sstl_cli.reporting.load import load

SAMPLE = Path(__file__).parents[2] / "data/samples/log.parquet"
SECTION = '''
"""How many inputs there are."""

TITLE = "Count <of> inputs"
ORDER = 1
NEEDS = ("log",)


def context(inputs):
    return {"count": len(inputs.files), "text": "<script>alert(1)</script>"}
'''


def shown(files: list[Path]) -> page_module.Page:
    return page_module.page(load(files), "t")


def test_a_dropped_in_section_is_shown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = shown([SAMPLE])
    (tmp_path / "counted.py").write_text(SECTION)
    (tmp_path / "counted.html.j2").write_text("<p>{{ count }} file: {{ text }}</p>")
    monkeypatch.setattr(sections, "__path__", [*sections.__path__, str(tmp_path)])
    monkeypatch.setattr(page_module, "FileSystemLoader", lambda folder: FileSystemLoader([folder, tmp_path]))
    try:
        after = shown([SAMPLE])
    finally:
        sys.modules.pop("sstl_cli.reporting.sections.counted", None)
    assert set(after.sections) - set(before.sections) == {"counted"}
    assert "<p>1 file: &lt;script&gt;alert(1)&lt;/script&gt;</p>" in after.html
    assert "Count &lt;of&gt; inputs" in after.html and "counted" not in before.html
    # ORDER = 1: before the section that came first
    assert after.html.index("1 file:") < after.html.index(f'id="{before.sections[0]}"')
