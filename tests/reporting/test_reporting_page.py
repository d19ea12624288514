"""The page: complete, self-contained, safe against hostile names, small, the same bytes each time."""

import base64
import hashlib
import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
import reporting_inputs as made
from markupsafe import escape
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from sstl_cli.core.errors import SstlError, UsageError
from sstl_cli.core.runs import read_runs
from sstl_cli.reporting import drawing, sections, table
from sstl_cli.reporting.diagnosed import Diagnosed
from sstl_cli.reporting.documents import read
from sstl_cli.reporting.inputs import Inputs, view
from sstl_cli.reporting.load import load
from sstl_cli.reporting.page import TEMPLATES
from sstl_cli.reporting.scored import Scored
from sstl_cli.reporting.words import sentence
from sstl_cli.steps import report
from tests import known_pictures

ROOT = Path(__file__).parents[2]
LOADING = {"src", "srcset", "poster", "data", "background", "xlink:href"}


class Outline(HTMLParser):
    """Collect what a reader's software would see."""

    def __init__(self, html):
        super().__init__()
        self.tags, self.ids, self.levels, self.scripts, self.texts = [], [], [], [], []
        self.feed(html)

    def handle_starttag(self, tag, attrs):
        attrs = dict(attrs)
        self.tags.append((tag, attrs))
        if "id" in attrs:
            self.ids.append(attrs["id"])
        if re.fullmatch(r"h[1-6]", tag):
            self.levels.append(int(tag[1]))

    def handle_data(self, data):
        self.texts.append(data)


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    return made.write_all(tmp_path_factory.mktemp("inputs"))


@pytest.fixture(scope="module")
def whole(files):
    return report.run(load(files))


@pytest.fixture(scope="module")
def html(whole):
    return whole.html


def test_every_section_is_there(whole):
    names = [name for name, _ in sections.find()]
    assert list(whole.sections) == names
    assert names[0] == "diagnosis" and {"logs", "theta", "mapping", "compensation", "blind"} <= set(names)


def test_a_section_appears_only_with_its_inputs(files):
    theta = next(f for f in files if f.name == "theta.parquet")
    assert report.run(load([theta])).sections == ("theta",)
    with pytest.raises(UsageError, match="E608"):
        report.run(load([next(f for f in files if f.name == "phases.parquet")]))


@pytest.mark.slow
def test_same_inputs_same_bytes_in_any_order(files, html, monkeypatch):
    monkeypatch.setattr(drawing, "picture", known_pictures.draw)
    assert report.run(load(files[::-1])).html == html


def test_hostile_names_stay_text(html):
    assert "<script>alert(1)" not in html
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in html
    outline = Outline(html)
    assert sum(tag == "script" for tag, _ in outline.tags) == 1
    assert not [a for _, attrs in outline.tags for a in attrs if a.startswith("on")]
    assert "".join(outline.texts).count(made.HOSTILE) >= 4


def test_no_control_character_or_mark_of_direction_of_the_data_is_in_the_page(tmp_path):
    name = "a\x9b31m\x1b[2J\u202eb"
    document = {**made.diagnosis(), "file": name, "tendon": name, "sentence": name, "notes": [name]}
    document["verdict"] = {**document["verdict"], "why": name}
    document["next_experiment"] = {"separates": [name], "trajectory": name, "why": name}
    run = replace(next(iter(read_runs(ROOT / "data/samples/log.parquet"))), run_id=name, config_id=name, trajectory=name)
    page = report.run(Inputs(diagnosis=[read(Diagnosed, document)], log=[view(run)])).html
    assert "a\\x9b31m\\x1b[2J\\u202eb" in page
    assert not [c for c in page if not c.isprintable() and c != "\n"]


def test_hostile_title_stays_text(files):
    theta = next(f for f in files if f.name == "theta.parquet")
    made_page = report.run(load([theta]), '</title><img src=x onerror="alert(1)">').html
    assert "<img" not in made_page


def test_nothing_is_loaded_from_anywhere(html):
    assert "http://" not in html and "https://" not in html and "@import" not in html
    for tag, attrs in Outline(html).tags:
        assert tag not in ("img", "iframe", "object", "embed", "base")
        assert not LOADING & set(attrs), (tag, attrs)
        assert tag not in ("a", "link", "use") or attrs["href"].startswith(("#", "data:")), attrs
    urls = re.findall(r"url\(([^)]*)\)", html)
    assert urls and all(u.startswith("#") for u in urls)


def test_policy_allows_the_one_script_alone(html):
    script = re.search(r"<script>(.*?)</script>", html, re.S).group(1)
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}'" in html and "default-src 'none'" in html


def test_references_inside_pictures_are_complete_and_unique(html):
    outline = Outline(html)
    assert len(outline.ids) == len(set(outline.ids))
    used = set(re.findall(r"url\(#([^)]+)\)", html)) | set(re.findall(r'href="#([^"]+)"', html))
    assert used <= set(outline.ids)


def test_accessible_by_structure(html):
    outline = Outline(html)
    assert ("html", {"lang": "en"}) in outline.tags
    assert outline.levels[0] == 1 and outline.levels.count(1) == 1
    assert all(b - a <= 1 for a, b in zip(outline.levels, outline.levels[1:], strict=False))
    pictures = [attrs for tag, attrs in outline.tags if tag == "svg"]
    assert len(pictures) > 20
    assert all(p.get("role") == "img" and len(p.get("aria-label", "")) > 20 for p in pictures)
    heads = [attrs for tag, attrs in outline.tags if tag == "th"]
    assert heads and all(h["scope"] == "col" and h["aria-sort"] == "none" for h in heads)


def luminance(colour):
    colour = colour if len(colour) == 7 else "#" + "".join(2 * c for c in colour[1:])
    parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def test_text_contrast_in_every_theme():
    themes = re.findall(r":root\{([^}]*)\}", (TEMPLATES / "page.css").read_text())
    assert len(themes) == 3
    for theme in themes:
        colours = dict(re.findall(r"--(\w+):(#[0-9a-f]+)", theme))
        for text in ("ink", "muted", "link", "ok", "warn"):
            for ground in ("paper", "panel"):
                a, b = sorted((luminance(colours[text]), luminance(colours[ground])))
                assert (b + 0.05) / (a + 0.05) >= 4.5, (text, ground, theme)


def test_numbers_in_cells_read_on_their_colour():
    axes = Figure().subplots()
    values = np.linspace(0.01, 1.0, 60).reshape(6, 10)
    drawing.heat(axes, values, list("abcdef"), list("abcdefghij"), "{:.2f}", 1.0)
    mesh = axes.collections[0]
    assert len(axes.texts) == values.size
    for text in axes.texts:
        cell = luminance(to_hex(mesh.cmap(mesh.norm(float(text.get_text())))))
        a, b = sorted((cell, luminance(text.get_color())))
        assert (b + 0.05) / (a + 0.05) >= 4.5, text


@pytest.mark.slow
def test_hundred_runs_stay_small(tmp_path):
    files = [*made.write_log(tmp_path, 100, 1500), *made.write_theta(tmp_path, 100), *made.write_compensation(tmp_path)]
    page = report.run(load([*files, *made.write_mapping(tmp_path), *made.write_documents(tmp_path)]))
    assert len(page.html.encode()) < 5e6
    # every run is in the overview and in the sampling table
    assert page.html.count("run-057") >= 3


def test_sparse_documents_are_enough():
    found = Inputs(diagnosis=[Diagnosed(file="d")], blind=[Scored(file="b")], files=[("diagnosis", "d", "0")])
    page = report.run(found)
    assert page.sections == ("diagnosis", "blind", "effects") and "holds no verdict" in page.html


@pytest.mark.parametrize("document", [{"where": "x"}, {"candidates": [1]}, {"gap": []}, {"verdict": {"effects": "x"}}])
def test_wrong_types_are_one_clear_error(document):
    with pytest.raises(SstlError, match="E604"):
        read(Diagnosed, {"schema": "sstl.diagnosis/1", **document})


@pytest.mark.parametrize(
    ("status", "effects", "text"),
    [
        ("identified", ["a_b", "c"], "The verdict is 'identified': a b and c."),
        ("ambiguous", ["a", "b", "c"], "The verdict is 'ambiguous': a, b and c."),
        ("unknown", [], "The verdict is 'unknown'."),
        ("none", [], "The verdict is 'none'."),
    ],
)
def test_the_verdict_comes_first_where_an_older_version_wrote_no_sentence(status, effects, text, tmp_path):
    document = made.diagnosis(effects, status)
    assert sentence(read(Diagnosed, document)) == text
    path = tmp_path / "d.json"
    path.write_text(json.dumps(document))
    section = report.run(load([path])).html.split('<section id="diagnosis"')[1]
    assert section.index(escape(text)) < section.index("<svg")


def test_a_long_table_is_cut_and_says_how_many_rows_it_leaves_out(files, monkeypatch):
    theta = load([next(f for f in files if f.name == "theta.parquet")])
    rows = len(theta.theta)
    assert "more stand in the file" not in report.run(theta).html
    monkeypatch.setattr(table, "MOST_ROWS", 2)
    html = report.run(theta).html
    assert f"The first 2 rows; {rows - 2} more stand in the file." in html
    # the header's row and two more
    assert html.split('<table aria-label="Parameters">')[1].split("</table>")[0].count("<tr>") == 3
