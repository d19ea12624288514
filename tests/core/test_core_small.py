"""Random streams, configuration, errors and units."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from spent import spent_s

from sstl_cli.core.config import MAX_TOML_BYTES, Model, parse, read_toml
from sstl_cli.core.documents.error import of
from sstl_cli.core.errors import GateError, SstlError, UsageError, cut, nearest, printable
from sstl_cli.core.files import read_json
from sstl_cli.core.rng import stream
from sstl_cli.core.units import UNITS, conversion, is_unit, unit_of


class Noise(Model):
    white_n: float = 0.0


class Rig(Model):
    sampling_hz: float
    noise: Noise = Noise()
    trajectories: list[Noise] = []


def test_streams_belong_to_their_names() -> None:
    assert stream(1, "noise", "a").random() == stream(1, "noise", "a").random()
    different = [stream(1, "noise", "a"), stream(2, "noise", "a"), stream(1, "noise", "b"), stream(1, "a", "noise"), stream(1)]
    assert len({s.random() for s in different}) == 5


def test_streams_do_not_depend_on_the_hash_seed() -> None:
    code = "from sstl_cli.core.rng import stream; print(stream(7, 'noise', 'run-0', 3).integers(1 << 62))"
    found = {
        subprocess.check_output([sys.executable, "-c", code], env={**os.environ, "PYTHONHASHSEED": seed}) for seed in ("0", "1", "12345")
    }
    assert len(found) == 1


def test_streams_look_independent() -> None:
    import numpy as np

    draws = np.array([stream(0, "x", i).standard_normal(400) for i in range(30)])
    off = np.corrcoef(draws)[np.triu_indices(30, 1)]
    # 435 correlations of 400 pairs: standard deviation 1/sqrt(400), largest of them within five
    assert np.abs(off).max() < 5 / np.sqrt(400) and abs(off.std() * np.sqrt(400) - 1) < 0.2


@pytest.mark.parametrize(
    ("document", "message"),
    [
        ({"sampling_hz": 1, "samling": 2}, "unknown key 'samling' .did you mean 'sampling_hz'"),
        ({"sampling_hz": 1, "noise": {"wite_n": 1}}, "'noise.wite_n' .did you mean 'white_n'"),
        ({"sampling_hz": 1, "trajectories": [{}, {"whiten": 1}]}, "'trajectories.1.whiten' .did you mean 'white_n'"),
        ({"sampling_hz": "fast"}, "'sampling_hz'.*number.*found 'fast'"),
        ({}, "'sampling_hz': Field required"),
        ({"sampling_hz": math.nan}, "'sampling_hz'.*finite"),
        ([1], "document"),
    ],
)
def test_configuration_says_what_is_wrong(document: object, message: str) -> None:
    with pytest.raises(SstlError, match=f"E143.*rig.toml.*{message}"):
        parse(Rig, document, "rig.toml")


def test_configuration_is_frozen() -> None:
    rig = parse(Rig, {"sampling_hz": 500}, "rig.toml")
    with pytest.raises(Exception, match="frozen"):
        rig.sampling_hz = 1.0
    assert rig.sampling_hz == 500.0


def test_toml_that_cannot_be_read(tmp_path: Path) -> None:
    path = tmp_path / "x.toml"
    with pytest.raises(SstlError, match="E141"):
        read_toml(path)
    for body in (b"a = ", b"\xff\xfe", b"a = " + b"[" * 50_000, b"a=1\na=2"):
        path.write_bytes(body)
        with pytest.raises(SstlError, match="E142"):
            read_toml(path)
    path.write_bytes(b"#" * (MAX_TOML_BYTES + 1))
    with pytest.raises(SstlError, match="E140"):
        read_toml(path)


def test_error_line_is_one_printable_line() -> None:
    error = SstlError("bad \x1b[31mred\nname\u202e", where="a\rb", fix="rename it", code="E999")
    assert error.line() == r"[E999] a\rb: bad \x1b[31mred\nname\u202e; rename it"
    assert (SstlError.exit_code, UsageError.exit_code, GateError.exit_code) == (1, 2, 4)


@pytest.mark.parametrize("filler", ["x", "x ", "\n", "\x1b"])
def test_long_values_are_cut_in_errors(filler: str) -> None:
    value = filler * 100_000
    for error in (SstlError(f"'{value}' is no number", where="a.toml", fix="give one"), UsageError("bad", where=value, fix=f"not {value}")):
        document = of(error)
        for text in (error.line(), document.message, document.fix, document.where):
            assert len(text) < 3000 and text.isprintable()
        assert "more characters) ..." in error.line() and "more characters) ..." in document.message
    assert SstlError(f"'{value}' is no number").line().endswith("' is no number")


def test_an_error_says_how_much_was_cut_and_leaves_paths_whole() -> None:
    assert SstlError("'" + "x" * 60_000 + "' is no number").line() == (
        f"[E000] '{'x' * 199}... (59752 more characters) ...{'x' * 49}' is no number"
    )
    path = "/".join(["folder"] * 50)
    assert SstlError("is missing", where=path).line() == f"[E000] {path}: is missing"
    assert cut(cut("y " * 9000)) == cut("y " * 9000)


@given(st.text())
def test_printable_is_always_safe(text: str) -> None:
    safe = printable(text)
    assert safe.isprintable() and "\x1b" not in safe and (not text.isprintable() or safe == text)


def test_nearest() -> None:
    assert nearest("tension_in", ["tension_in_n", "time_s"]) == "did you mean 'tension_in_n'?"
    assert nearest("zzz", ["b", "a"]) == "known: a, b"
    assert nearest("zzz", [f"{i:02d}" for i in range(20)]).endswith("11, ...")


def test_units_against_their_definitions() -> None:
    # BIPM SI brochure, NIST SP 811: exact by definition
    assert unit_of("lbf") == ("force", pytest.approx(4.4482216152605, rel=1e-14))
    assert unit_of("kgf") == ("force", 9.80665)
    assert unit_of("psi") == ("pressure", pytest.approx(6894.757293168, rel=1e-12))
    assert unit_of("in") == ("length", 25.4) and unit_of(" mN ") == ("force", 1e-3)
    assert unit_of("µm") == unit_of("um") and unit_of("°") == ("angle", math.pi / 180)


def test_unknown_unit_names_the_nearest() -> None:
    assert not is_unit("Newtonn")
    with pytest.raises(SstlError, match="E301.*'n'.*did you mean 'N'"):
        unit_of("n")
    with pytest.raises(SstlError, match="E301"):
        unit_of("furlong")


def test_conversions() -> None:
    assert conversion("mN", "force", sign=-1, offset=5).factor == -1e-3
    assert conversion("V", "force", gain=20.0, offset=0.1) == conversion("mV", "force", gain=20_000.0, offset=0.1)
    assert conversion("rev", "length", radius_mm=10.0).factor == pytest.approx(62.83185307)
    # 1 bar on 100 mm2 is 10 N
    assert conversion("bar", "force", area_mm2=100.0).factor == pytest.approx(10.0)


@pytest.mark.parametrize(
    ("unit", "target", "more", "message"),
    [
        ("s", "force", {}, "s is a time, not a force"),
        ("deg", "force", {}, "deg is an angle, not a force"),
        ("deg", "length", {}, "spool radius"),
        ("bar", "force", {}, "piston area"),
        ("V", "force", {}, "needs a gain"),
        ("N", "force", {"gain": 2.0}, "gain belongs to V or counts"),
    ],
)
def test_impossible_conversions(unit: str, target: str, more: dict, message: str) -> None:
    with pytest.raises(SstlError, match=f"E302.*tension_in_n.*{message}"):
        conversion(unit, target, where="tension_in_n", **more)


@given(st.sampled_from(sorted(UNITS)))
def test_every_unit_is_known_by_its_name(name: str) -> None:
    dimension, factor = unit_of(name)
    assert is_unit(name) and factor > 0 and dimension


@pytest.mark.parametrize(
    "text",
    [
        ".".join(["a"] * 50_000) + " = 1",
        "[" + ".".join(["a"] * 50_000) + "]",
        "[[" + " . ".join(['"a,="'] * 50_000) + "]]",
        "x = {" + ".".join(["a"] * 50_000) + " = 1}",
        "x = " + "{a.b.c.d.e=" * 60 + "1" + "}" * 60,
        "x = " + "[" * 200 + "]" * 200,
        'x = "' + '\\"' * 1_000_000,
    ],
)
def test_toml_of_any_shape_is_refused_in_no_time(text: str, tmp_path: Path) -> None:
    (tmp_path / "x.toml").write_text(text)
    started = spent_s()
    with pytest.raises(SstlError, match="E142"):
        read_toml(tmp_path / "x.toml")
    assert spent_s() - started < 3.0


def test_many_dots_that_are_no_key_are_fine(tmp_path: Path) -> None:
    numbers = ", ".join(["0.5"] * 500)
    (tmp_path / "x.toml").write_text(f'x = [{numbers}]\n# {"a." * 90}\ny = "{"a." * 90}"\nz = [\n{numbers}\n]\n')
    assert len(read_toml(tmp_path / "x.toml")["z"]) == 500


def test_json_nested_without_end_is_refused(tmp_path: Path) -> None:
    (tmp_path / "x.json").write_text("[" * 500 + "]" * 500)
    with pytest.raises(SstlError, match="E111.*nested"):
        read_json(tmp_path / "x.json")
