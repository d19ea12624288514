"""The program as a whole: help, precedence, what it imports and records."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Annotated

import pyarrow.parquet as pq
import pytest
import typer
from cli_calls import run_here, sstl
from program import inside
from spent import spent_s
from typer.core import TyperGroup

from sstl_cli.cli import app as program
from sstl_cli.cli.options import Config, Json
from sstl_cli.cli.origin import command_line

SAMPLE = Path(__file__).parents[2] / "data/samples/log.parquet"
CONTRACT = [
    "simulate",
    "import",
    "check",
    "info",
    "segment",
    "train",
    "evaluate",
    "compensate",
    "diagnose",
    "blind",
    "reproduce",
    "report",
    "effects",
    "export",
]


def commands() -> list[tuple[str, ...]]:
    """Every command and subcommand as registered."""
    program._register()

    def walk(command: object, path: tuple[str, ...]) -> list[tuple[str, ...]]:
        inner = command.commands if isinstance(command, TyperGroup) else {}
        return [path, *(p for name, c in inner.items() for p in walk(c, (*path, name)))]

    return walk(typer.main.get_command(program.app), ())[1:]


def test_commands_of_the_contract_come_in_the_order_of_the_work(monkeypatch, capsys) -> None:
    assert run_here(monkeypatch, "--help") == 0
    shown = [line.split()[0] for line in capsys.readouterr().out.split("Commands:\n")[1].splitlines() if line.strip()]
    assert shown[: len(CONTRACT)] == CONTRACT


@pytest.mark.parametrize("path", commands(), ids=" ".join)
def test_every_help_has_an_example(path, monkeypatch, capsys) -> None:
    assert run_here(monkeypatch, *path, "--help") == 0
    text = capsys.readouterr().out
    assert "Example" in text and f"sstl {' '.join(path)}" in text.split("Example")[1]


@pytest.mark.parametrize("path", [p for p in commands() if p not in (("blind",), ("effects",))], ids=" ".join)
def test_every_command_has_the_shared_options(path, monkeypatch, capsys) -> None:
    run_here(monkeypatch, *path, "--help")
    text = capsys.readouterr().out
    assert "--json" in text
    assert "--config" in text
    # what writes a file can overwrite it
    assert ("--force" in text) == ("--out" in text or path[:2] in (("blind", "make"), ("blind", "run"))) or path in (
        ("blind", "real"),
        ("blind", "limit"),
        ("blind", "library"),
    )


@pytest.mark.parametrize("path", commands(), ids=" ".join)
def test_help_names_values_in_plain_words(path, monkeypatch, capsys) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    run_here(monkeypatch, *path, "--help")
    text = capsys.readouterr().out
    assert not [w for w in ("[[", "...}", "list[", " range>", "<str>", "<int>", "<float>") if w in text]
    assert max(map(len, text.splitlines())) <= 80


def test_version(monkeypatch, capsys) -> None:
    from sstl_cli import __version__

    monkeypatch.setenv("SSTL_VERSION", "nonsense")  # a variable a user may well have for other reasons
    assert run_here(monkeypatch, "--version") == 0
    assert capsys.readouterr().out == f"sstl {__version__}\n"
    assert run_here(monkeypatch, "effects", "list", "--json") == 0
    run_here(monkeypatch, "--help")
    assert "SSTL_VERSION" not in capsys.readouterr().out


@pytest.mark.parametrize("words", [("segmentt",), ("segment",), ("segment", "x", "--no-such"), ("check", "--json")])
def test_wrong_usage_is_2(words, monkeypatch, capsys) -> None:
    assert run_here(monkeypatch, *words) == 2
    assert "Traceback" not in capsys.readouterr().err


def test_help_imports_nothing_heavy_and_is_quick() -> None:
    code = (
        "import sys; sys.argv = ['sstl', '--help']\n"
        "from sstl_cli.cli.app import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        "heavy = {'numpy', 'pyarrow', 'torch', 'numba', 'pandas', 'scipy', 'pydantic', 'matplotlib'}\n"
        "print(sorted(heavy & set(sys.modules)), file=sys.stderr)"
    )
    took = []
    for _ in range(3):
        before = spent_s()
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
        took.append(spent_s() - before)
        assert done.stderr.strip() == "[]"
    # contract: 0.5 s, in processor time
    assert min(took) < 0.5


# precedence: flag > environment > file > default


@pytest.fixture
def probe(monkeypatch, capsys):
    """A subcommand that says what it was given, in a program of its own with the same settings."""
    own = typer.Typer(context_settings=program.app.info.context_settings, pretty_exceptions_enable=False)

    @own.callback()
    def _root() -> None: ...

    @own.command("segment")
    def segment(
        cutoff_hz: float = 1.0,
        weight_inv: Annotated[float, typer.Option("--lambda")] = 2.0,
        effect: Annotated[list[str] | None, typer.Option()] = None,
        as_json: Json = False,
        config: Config = None,
    ) -> None:
        print(cutoff_hz, weight_inv, effect, as_json)

    @own.command("train")
    def train(epochs: int = 3, config: Config = None) -> None: ...

    def call(*words: object) -> str:
        own(list(map(str, words)), standalone_mode=False)
        return capsys.readouterr().out.strip()

    return call


def test_flag_over_environment_over_file_over_default(probe, tmp_path, monkeypatch) -> None:
    file = tmp_path / "c.toml"
    file.write_text("[segment]\ncutoff-hz = 3.0\n")
    assert probe("segment").startswith("1.0")
    assert probe("segment", "--config", file).startswith("3.0")
    monkeypatch.setenv("SSTL_SEGMENT_CUTOFF_HZ", "4.0")
    assert probe("segment", "--config", file).startswith("4.0")
    assert probe("segment", "--config", file, "--cutoff-hz", "5.0").startswith("5.0")
    monkeypatch.delenv("SSTL_SEGMENT_CUTOFF_HZ")
    monkeypatch.setenv("SSTL_SEGMENT_CONFIG", str(file))
    assert probe("segment").startswith("3.0")


def test_file_keys_are_the_names_of_the_options(probe, tmp_path) -> None:
    file = tmp_path / "c.toml"
    file.write_text("cutoff_hz = 3.0\nepochs = 7\n[segment]\nlambda = 0.5\neffect = ['a', 'b']\njson = true\n")
    # epochs belongs to another command: shared files are fine
    assert probe("segment", "--config", file) == "3.0 0.5 ['a', 'b'] True"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[segment]\ncutof_hz = 1.0", "E150.*'cutof_hz'.*did you mean 'cutoff-hz'"),
        ("cutof_hz = 1.0", "E150.*'cutof_hz'"),
        ("[segment]\nepochs = 1", "E150.*'epochs'"),
        ("segment = 3", "E151.*not a table"),
        ("[segmnt]\ncutoff_hz = 3.0", r"E150.*unknown table \[segmnt\] \(did you mean 'segment'"),
        ("[segment]\n[segment.more]\na = 1", r"E150.*unknown table \[segment.more\] \(give its options as keys"),
        ("a = ", "E142"),
    ],
)
def test_wrong_configuration_file(probe, tmp_path, text, says) -> None:
    from sstl_cli.core.errors import SstlError

    file = tmp_path / "c.toml"
    file.write_text(text)
    with pytest.raises(SstlError, match=says):
        probe("segment", "--config", file)


def test_a_table_of_no_command_is_refused_by_any(tmp_path) -> None:
    """It was without effect, and no word said."""
    (tmp_path / "c.toml").write_text("[blind.make]\ncases = 3\n[batch]\nworkers = 1\n[train]\nseed = 1\n")
    assert inside("info", SAMPLE, "--config", "c.toml", cwd=tmp_path).returncode == 0
    for table, said in (("blind.mak", "did you mean 'blind.make'"), ("trian", "did you mean 'train'")):
        (tmp_path / "c.toml").write_text(f"[{table}]\nseed = 3\n")
        done = inside("info", SAMPLE, "--config", "c.toml", cwd=tmp_path)
        assert done.returncode == 2 and f"unknown table [{table}] ({said}" in done.stderr


def test_precedence_reaches_a_real_command(tmp_path) -> None:
    (tmp_path / "c.toml").write_text("[segment]\nseed = 5\ndelta_bl_n = 0.3\n")
    words = ("segment", SAMPLE, "--out", "t.parquet", "--config", "c.toml")
    done = inside(*words, cwd=tmp_path, SSTL_SEGMENT_SEED="6", SSTL_SEGMENT_JSON="1")
    assert done.returncode == 0 and '"seed": 6' in done.stdout


@pytest.mark.parametrize(
    ("path", "variable"),
    [
        (("train",), "SSTL_TRAIN_LAMBDA"),
        (("import",), "SSTL_IMPORT_MAP"),
        (("blind", "make"), "SSTL_BLIND_MAKE_SEED"),
        (("effects", "list"), "SSTL_EFFECTS_LIST_JSON"),
    ],
)
def test_variables_are_named_like_the_options(path, variable, monkeypatch, capsys) -> None:
    run_here(monkeypatch, *path, "--help")
    # one line for all of them, not one an option; long names are broken over lines
    shown = "".join(capsys.readouterr().out.split())
    assert f"SSTL_{'_'.join(path).upper()}_OPTION" in shown and "[envvar:" not in shown
    command = typer.main.get_command(program.app)
    for name in path:
        command = command.get_command(typer.Context(command), name)
    assert variable in [p.envvar for p in command.params]


def test_options_are_grouped(monkeypatch, capsys) -> None:
    run_here(monkeypatch, "diagnose", "--help")
    text = capsys.readouterr().out
    titles = ["Arguments:", "Options:", "Outputs:", "Gates (exit 4 if missed):", "Common options:"]
    places = [text.index(t) for t in titles]
    assert places == sorted(places)
    assert places[3] < text.index("--max-rmse") < places[4] < text.index("--quiet")
    assert places[2] < text.index("--save-sim") < places[3]


def test_quiet_and_verbose(tmp_path, monkeypatch, capsys) -> None:
    short = tmp_path / "short.parquet"
    pq.write_table(pq.read_table(SAMPLE).slice(0, 3), short)
    words = ("segment", short, "-o", tmp_path / "t.parquet", "--force")
    assert run_here(monkeypatch, *words, "-q") == 3
    quiet = capsys.readouterr()
    assert quiet.err == "" and "Found both propagation lines" in quiet.out
    made = (tmp_path / "t.parquet").read_bytes()
    assert run_here(monkeypatch, *words, "-v") == 3
    assert "set aside" in (said := capsys.readouterr().err) and "took " in said and "MB at most" in said
    # how it was shown does not change what was made
    assert (tmp_path / "t.parquet").read_bytes() == made
    # an error is no narration
    assert run_here(monkeypatch, "check", "-q", "absent.parquet") == 1
    assert run_here(monkeypatch, "info", "-q", "absent.parquet") == 1 and "absent.parquet" in capsys.readouterr().err


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_in_three_shells(shell) -> None:
    assert "_SSTL_COMPLETE" in sstl("--show-completion", shell, _TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION="1").stdout
    asked = {"_SSTL_COMPLETE": f"complete_{shell}", "_TYPER_COMPLETE_ARGS": "sstl seg", "COMP_WORDS": "sstl seg", "COMP_CWORD": "1"}
    more = {"_TYPER_COMPLETE_FISH_ACTION": "get-args", "_TYPER_COMPLETE_WORD_TO_COMPLETE": "seg"}
    code = "import sys; sys.argv = ['sstl']; from sstl_cli.cli.app import main; main()"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env={**os.environ, **asked, **more})
    assert "segment" in done.stdout and "Traceback" not in done.stderr


def test_wrong_type_in_environment_is_a_usage_error() -> None:
    done = inside("segment", SAMPLE, "-o", "x", SSTL_SEGMENT_SEED="many")
    assert done.returncode == 2 and "--seed" in done.stderr


# provenance


@pytest.mark.parametrize(
    ("words", "kept"),
    [
        (["segment", "/data/a/log.parquet", "--out=/tmp/x/t.parquet"], "segment log.parquet --out=t.parquet"),
        (["simulate", "-o", "x.parquet", "--force", "--json", "--seed", "1"], "simulate -o x.parquet --seed 1"),
        (["a", "--workers", "4", "--seed", "1"], "a --seed 1"),
        (["a", "--workers=4", "s3://bucket/x", "--map", "time_s=/t.*/:ms"], "a s3://bucket/x --map time_s=/t.*/:ms"),
    ],
)
def test_command_line_keeps_what_decides_the_bytes(words, kept, monkeypatch) -> None:
    monkeypatch.setattr(sys, "argv", ["/usr/bin/sstl", *words])
    assert command_line() == f"sstl {kept}"


def test_rerun_with_force_and_json_gives_the_same_bytes(tmp_path) -> None:
    # one process of another hash seed among them
    for folder, more, apart in (("a", (), {}), ("b", ("--json",), {"PYTHONHASHSEED": "1"}), ("a", ("--force",), {})):
        (tmp_path / folder).mkdir(exist_ok=True)
        done = (sstl if apart else inside)("segment", SAMPLE, "--out", tmp_path / folder / "t.parquet", *more, **apart)
        assert done.returncode == 0, done.stderr
        bytes_now = (tmp_path / folder / "t.parquet").read_bytes()
        first = bytes_now if folder == "a" and not more else first  # noqa: F821
        assert bytes_now == first
