"""Numbers on pages are those of the files that they come from, and targets are judged as they are meant."""

from __future__ import annotations

import re
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from sstl_cli.blind.learning import examples
from sstl_cli.blind.library import facts_of, read_library
from sstl_cli.diagnosis.adjusted import NONE, UNKNOWN
from sstl_cli.diagnosis.features import OUTPUT
from sstl_cli.diagnosis.verdict import decided, probabilities
from sstl_cli.diagnosis.weights import learned

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tools"))
import blind_table  # noqa: E402
import house  # noqa: E402
import page_part  # noqa: E402
from likelihood_targets import Measured, targets  # noqa: E402


def told(page: str, name: str) -> str:
    return page_part.inside(page, name)


def test_the_distance_that_shows_is_that_of_the_weights() -> None:
    text = (ROOT / "docs/limit.md").read_text(encoding="utf-8")
    plain, beside = re.search(r"D\^2 = ([\d.]+) on \(([\d.]+) beside an accepted model", text).groups()
    assert (float(plain), float(beside)) == (learned().shows_d2, learned(True).shows_d2)


def test_the_power_of_the_odds_is_that_of_the_weights() -> None:
    text = " ".join((ROOT / "docs/diagnosis.md").read_text(encoding="utf-8").split())
    plain, beside = re.search(r"raised to a learned power \(([\d.]+); ([\d.]+) beside an accepted model\)", text).groups()
    assert (float(plain), float(beside)) == (learned().temper, learned(True).temper)


def test_how_often_a_set_holds_the_truth_is_that_of_the_published_set() -> None:
    text = " ".join((ROOT / "docs/diagnosis.md").read_text(encoding="utf-8").split())
    held = re.search(r"\((\d+ of \d+) on the sealed set", text)[1]
    assert f"| {held} (" in re.search(r"^\| coverage of the ambiguity set \|.*$", told("blind.md", "published"), re.M)[0]


@pytest.mark.slow
def test_how_many_effects_at_the_limit_are_called_nothing() -> None:
    text = (ROOT / "docs/limit.md").read_text(encoding="utf-8")
    k, n = map(int, re.search(r"gained 10 to 14 nats \(D\^2 about 24\) (\d+) of (\d+) were called `none`", text).groups())
    libraries = [p for p in sorted((ROOT / "data").glob("library-*.parquet")) if not facts_of(p).accepted]
    drawn = [e for p in libraries for e in examples(read_library(p)) if e.kind != "without"]
    found = []
    for e in drawn:
        own = [c.gain for c in e.rows.candidates if c.ids == e.answer and c.kind == OUTPUT]
        if len(e.answer) == 1 and e.answer not in (NONE, UNKNOWN) and own and 10.0 <= own[0] <= 14.0:
            found.append(decided(e.rows, probabilities(e.rows, learned()), learned()).status == "none")
    assert (sum(found), len(found)) == (k, n)


def test_the_front_page_has_the_targets_of_the_published_set() -> None:
    front, page = told("../README.md", "blind"), told("blind.md", "published")
    rows = re.findall(r"^\| .* \| (?:met|\*\*missed\*\*) \|$", front, re.M)
    assert len(rows) >= 15 and all(row in page for row in rows)
    # what was said of it cannot be said of other numbers
    assert "| 0-6 | " in told("limit.md", "score") and (ROOT / "docs/isolation.svg").exists()


def calibrated() -> list[dict[str, object]]:
    """The rows of the table of calibration, as the page of the published set has them."""
    head, _, *rows = re.search(r"^\| cases \| verdicts \| mean stated .*\n(?:\|.*\n)+", told("blind.md", "published"), re.M)[0].splitlines()
    names = {"verdicts": "n", "mean stated": "stated", "share right": "right", "calibration error": "ece", "by chance": "ece_chance"}
    keys = [{**names, "by chance, 95 % point": "ece_chance_95"}.get(h, h) for h in cells(head)]
    return [{k: v if k == "cases" or "(" in v else float(v) for k, v in zip(keys, cells(row), strict=True)} for row in rows]


def cells(row: str) -> list[str]:
    return row.strip("| ").split(" | ")


def test_the_front_page_says_of_the_confidence_what_the_table_of_calibration_does() -> None:
    rows = [{**r, "n": int(r["n"])} for r in calibrated()]
    assert len(rows) == 3 and blind_table.confidence(rows) in told("../README.md", "blind")
    high = [{**r, "stated": 0.95} for r in rows]
    assert "too high" in blind_table.confidence(high) and "too low" not in blind_table.confidence(high)
    assert "as often right as it says" in blind_table.confidence([{**r, "ece": 0.01} for r in rows])


def test_the_front_page_says_what_the_published_set_did() -> None:
    page = told("blind.md", "published")

    def last(row: str) -> tuple[int, int]:
        k, n = re.search(
            rf"^\| {row} \|.*\| (\d+) of (\d+) \([^|]*\|$", page.split("Cases that their recordings could decide")[0], re.M
        ).groups()
        return int(k), int(n)

    front = (ROOT / "README.md").read_text(encoding="utf-8").split("How often is the diagnosis right?")[1].split("<!-- blind begins")[0]
    numbers = re.search(
        r"(\d+) of (\d+) got `none`.*?(\d+) of (\d+) got\sa wrong name; of single effects above 0.6 times the noise two of three were named, "
        r"and (\d+) of (\d+) are in the set", front, re.S
    ).groups()  # fmt: skip
    sound, nulls, wrong, lacking, held, singles = map(int, numbers)
    targets = {m[0]: (int(m[1]), int(m[2])) for m in re.findall(r"^\| ([^|]+) \| [\d.]+ % \| (\d+) of (\d+) ", page, re.M)}
    assert (nulls - sound, nulls) == targets["false alarm"] and (wrong, lacking) == targets["wrong commits"]
    k, n = targets["isolation above 0.6 x noise"]
    assert n == singles and round(3.0 * k / n) == 2
    assert held == last("in the group at 1.2 x noise")[0] + last("in the group at 4 x noise")[0]


def test_a_full_set_is_made_as_the_published_one_was() -> None:
    words = re.search(r"^PUBLISHED := (.+)$", (ROOT / "Makefile").read_text(encoding="utf-8"), re.M)[1].strip()
    assert re.match(r"`sstl blind make set ([^`]+)`", told("blind.md", "published").strip())[1] == words
    assert f"({words})" in told("../README.md", "blind")


def share(k: int, n: int, low: float, high: float) -> dict[str, float]:
    return {"k": k, "n": n, "share": k / n, "low": low, "high": high}


def test_what_a_foreign_simulator_loses_is_counted_towards_the_worse() -> None:
    rest = dict.fromkeys(blind_table.SAID)
    own = {**rest, "isolation": share(8, 10, 0.6, 0.9), "false_alarm": share(1, 10, 0.0, 0.3), "ece": 0.1}
    far = {**rest, "isolation": share(5, 10, 0.3, 0.7), "false_alarm": share(3, 10, 0.1, 0.5), "ece": 0.2}
    score = {
        "by_simulator": [{"simulator": "rig", "scores": own}, {"simulator": "bristle", "scores": far}, {"simulator": "all", "scores": own}]
    }
    found = {said: row for said, simulator, row in blind_table.losses(score) if simulator == "bristle"}
    assert set(found) == {"isolation above 0.6 x noise", "false alarm"}
    assert found["isolation above 0.6 x noise"][0] == pytest.approx(30.0) and found["false alarm"][0] == pytest.approx(20.0)
    # Newcombe: from 0.3 - hypot(0.2, 0.2) to 0.3 + hypot(0.1, 0.2)
    assert found["isolation above 0.6 x noise"][1:] == (pytest.approx(1.716, abs=1e-3), pytest.approx(52.36, abs=1e-2))
    assert "**missed**, not beyond chance" in blind_table.foreign(score)


GOOD = Measured(
    {"rig, PB": 1.01, "rig, PP": 0.985}, 25_000, 0.001, {"pull": (1.0, 1.0)}, {"gain_error": 1.1},
    {"viscous": (200, 12), "stribeck": (200, 10)}, {"viscous": (0.0, 3.0, 28)}, [0.96, 0.99],
)  # fmt: skip


def marks(m: Measured) -> list[bool]:
    return [line.endswith("| met |") for line in targets(m)[4:]]


def test_a_likelihood_as_it_should_be_meets_every_target() -> None:
    assert marks(GOOD) == [True] * 8


@pytest.mark.parametrize(
    ("place", "change"),
    [
        (0, {"chi2": {"rig, PB": 1.03}}), (1, {"samples": 19_000}), (2, {"neighbours": -0.03}), (3, {"holds": {"pull": (5.0, 1.3)}}),
        (4, {"ratios": {"gain_error": 11.0}}), (5, {"chance": {"viscous": (196, 29)}}), (6, {"refitted": {"viscous": (0.0, 15.0, 28)}}),
        (7, {"kept": [0.67, 0.99]}),
    ],
)  # fmt: skip
def test_each_target_of_the_likelihood_can_be_missed(place: int, change: dict[str, object]) -> None:
    assert marks(replace(GOOD, **change)) == [i != place for i in range(8)]


def test_values_without_a_type_are_counted_by_either_name(tmp_path: Path) -> None:
    (tmp_path / "sstl_cli/core").mkdir(parents=True)
    (tmp_path / "sstl_cli/core/one.py").write_text(
        "def f(a: dict[str, Any], b: Mapping[str, object]) -> dict[str, object]:\n    return {}\n"
    )
    found = house.counted(tmp_path)
    assert (found["`dict[str, Any]` and `Mapping[str, Any]`"], found["`dict[str, object]` and `Mapping[str, object]`"]) == (1, 2)


def test_what_is_said_of_the_house_is_what_was_counted() -> None:
    page = told("../CONTRIBUTING.md", "house")
    before, now = ({r[0]: int(r[i]) for r in re.findall(r"^\| (.*) \| (\d+) \| (\d+) \|$", page, re.M)} for i in (1, 2))
    untyped = [k for k in now if "[str, " in k]
    assert len(untyped) == 2

    def share(names: list[str]) -> float:
        return sum(now[n] for n in names) / sum(before[n] for n in names)

    assert share(untyped) == pytest.approx(1 / 3, abs=0.03) and share(["`dict[str, Any]` and `Mapping[str, Any]`"]) == pytest.approx(
        1 / 8, abs=0.02
    )
    outer = [sum(c[f"lines in {n}"] for n in ("cli", "steps")) / c["lines in all"] for c in (before, now)]
    assert outer == [pytest.approx(1 / 3, abs=0.05), pytest.approx(1 / 6, abs=0.03)]
    assert "a third of the mappings whose values have no type, an eighth of" in (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")


def test_what_is_said_of_trials_is_what_their_rows_say() -> None:
    text = (ROOT / "docs/reproduction.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\w+) \| (`\w+`(?:: \w+)?) \| (\w+), on trial \|(.*)$", text, re.M)
    changes = {withheld: [float(b) / float(a) - 1.0 for a, b in re.findall(r"([\d.]+) -> ([\d.]+)", rest)] for withheld, _, _, rest in rows}
    right = [withheld for withheld, _, put_in, _ in rows if put_in == withheld]
    said = " ".join(text.split())
    answers = {withheld: answer for withheld, answer, _, _ in rows}
    assert len(rows) == 6 and "None of six withheld effects is named for sure" in said
    assert (
        answers.pop("zero_offset") == "`ambiguous`: zero_offset"
        and set(answers.values()) == {"`unknown`"}
        and "`zero_offset` alone is in its set" in said
    )
    assert len(right) == 5 and "five of six are what is missing" in said
    # of the wrong one: promised table and tracking
    (wrong,) = set(changes) - set(right)
    worse, slower = (round(100 * changes[wrong][i]) for i in (1, 2))
    assert f"makes the promised table and the tracking worse by {worse} % and {slower} %" in said
    *most, least = sorted(round(-100 * changes[e][0]) for e in right)[::-1]
    assert f"Four of five right ones take away {min(most)} to {max(most)} % of the error on withheld bends" in said and abs(least) < 5
    first = re.search(r"^\| presliding, slow-speed friction \| load_dependent_friction \+ presliding \|(.*)$", text, re.M)[1]
    bends, promised, tracked = (1.0 - float(b) / float(a) for a, b in re.findall(r"([\d.]+) -> ([\d.]+)", first))
    assert 0.6 < bends < 0.7 and "falls by two thirds" in said and 0.7 < promised < 0.78 and "comes three quarters nearer" in said
    assert abs(tracked) < 0.01 and "what is tracked stays as it is" in said


def beyond(title: str) -> dict[str, list[float]]:
    """The numbers of each row of a printed table of what lies beyond the paper, by its first words (the last ones where a name comes again)."""
    text = (ROOT / "docs/beyond.txt").read_text(encoding="utf-8")
    body = text[text.index(title) :].split("---\n", 1)[1].split("\n\n")[0].splitlines()
    rows = [re.fullmatch(r"(\S.*?)((?:\s+(?:[-\d.]+))+)", line) for line in body]
    return {m[1]: [float(x) for x in m[2].split() if x != "-"] for m in rows if m}


def test_what_is_said_beyond_the_paper_is_what_was_printed() -> None:
    part = (ROOT / "docs/reproduction.md").read_text(encoding="utf-8").split("## Beyond the paper")[1]
    said = {m[1]: [float(x) for x in re.findall(r"[\d.]+", m[2])] for m in re.finditer(r"^\| ([^|]+) \| (.*[\d.]+.*) \|$", part, re.M)}
    names = {
        "direct identification": "direct identification (distal sensor)", "the paper's pipeline": "the paper's pipeline",
        "physics-informed mapping, lead": "+ loop-lag lead", "and exact inverse": "+ exact inverse at reversals",
        "and presliding followed": "+ presliding followed (all means)",
    }  # fmt: skip
    turned = beyond("The reversal region")
    for name, printed in names.items():
        turn, *_, peak = (turned[printed][i] for i in (0, 1, 2))
        assert said[name][0] == turn and said[name][2] == pytest.approx(peak, abs=0.051), name
        assert said[name][3:5] == turned[printed][3:5] and said[name][5] == pytest.approx(turned[printed][5], abs=0.051)
    plain = " ".join(part.split())
    probes = beyond("A shorter probe: rig")
    assert "0.306 against 0.294 N" in plain and probes["full stroke, faster"][-1] == 0.306
    assert f"30 % of the stroke in 0.25 s does ({probes['30 % of the stroke, faster'][-1]:.3f} N)" in plain
    dragged = beyond("A shorter probe: with drag, calibrated at two speeds")["full stroke, faster"][-1]
    assert f"at two speeds, {dragged:.3f} against 0.286 N" in plain
    assert f"by chance ({beyond('A shorter probe: with drag, calibrated at one speed')['full stroke, faster'][-1]:.3f} N)" in plain
    tendons = beyond("Several tendons tracked at once")
    assert said["a map each"][3:] == tendons["a map each, neighbours ignored"][-3:]
    assert said["and slopes follow the neighbours' tension"][3:] == tendons["a map each, slopes follow the neighbours"][-3:]
    sinusoid, random, *_ = beyond("An actively bending distal joint")["all means, joint inverted"]
    assert f"backwards through the joint {sinusoid:g} and {random:g} N" in plain
