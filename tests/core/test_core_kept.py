"""A read-only installation without a home: compiled functions go to a private temporary folder, or nowhere."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from sstl_cli.core import kept

ROOT = Path(__file__).parents[2]
ROOT_USER = hasattr(os, "geteuid") and os.geteuid() == 0


@pytest.fixture
def bare(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """No home, a package that cannot be written, temporary files in tmp_path."""
    monkeypatch.setattr(kept, "_tree_writable", lambda: False)
    for name in ("NUMBA_CACHE_DIR", "MPLCONFIGDIR", "XDG_CACHE_HOME", "XDG_CONFIG_HOME"):
        # set first: what the code under test sets must be taken back too
        monkeypatch.setenv(name, "")
        monkeypatch.delenv(name)
    file = tmp_path / "file"
    file.write_text("")
    monkeypatch.setenv("HOME", str(file / "none"))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    return tmp_path


def test_a_private_temporary_folder_where_nothing_else_can_be_written(bare: Path) -> None:
    found = kept.ensure()
    assert found.folder == bare / f"sstl-{os.getuid()}" / "compiled" and "neither" in found.why
    assert os.environ["NUMBA_CACHE_DIR"] == str(found.folder) and os.environ["MPLCONFIGDIR"].endswith("fonts")
    assert found.folder.stat().st_mode & 0o077 == 0
    assert kept.ensure().folder == found.folder


def test_the_folder_that_was_asked_for_is_not_forgotten(bare: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(bare / "file"))
    found = kept.ensure()
    # numba is told of another folder, and doctor still says which one could not be written
    assert os.environ["NUMBA_CACHE_DIR"] == str(found.folder) and not found.as_asked
    assert found.why.startswith(f"NUMBA_CACHE_DIR={bare / 'file'} cannot be written; neither")


def test_a_folder_that_others_can_write_is_not_taken(bare: Path) -> None:
    (bare / f"sstl-{os.getuid()}").mkdir()
    (bare / f"sstl-{os.getuid()}").chmod(0o777)
    assert kept.private("compiled") is None


def test_a_link_is_not_followed(bare: Path) -> None:
    (bare / "elsewhere").mkdir()
    (bare / f"sstl-{os.getuid()}").symlink_to(bare / "elsewhere")
    assert kept.private("compiled") is None


def test_without_any_folder_nothing_is_kept_and_functions_still_compile(bare: Path) -> None:
    code = (
        "from pathlib import Path\n"
        "from sstl_cli.core import kept\n"
        "kept._tree_writable = lambda: False\nkept._can_make = lambda folder: False\nkept.private = lambda name: None\n"
        "assert kept.ensure().folder is None\n"
        "from numba import njit\n"
        "@njit(cache=True)\n"
        "def twice(x): return 2 * x\n"
        "print(twice(21))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.strip() == "42", done.stderr


def test_pictures_keep_their_fonts_beside_the_output_where_nothing_else_can_be_written(bare: Path) -> None:
    out = bare / "out"
    out.mkdir()
    code = (
        "import os, sys\n"
        "from pathlib import Path\n"
        "from sstl_cli.core import kept\n"
        "import tempfile\n"
        "def nowhere(*a, **k):\n"
        "    if k.get('dir') is None: raise FileNotFoundError(2, 'no usable temporary folder')\n"
        "    return made(*a, **k)\n"
        "made, tempfile.mkdtemp = tempfile.mkdtemp, nowhere\n"
        "os.environ.pop('MPLCONFIGDIR', None)\n"
        "kept.fonts_beside(Path(sys.argv[1]) / 'x.png')\n"
        "import matplotlib.font_manager\n"
        "print(len(list(Path(sys.argv[1]).glob('.sstl-fonts-*'))))\n"
    )
    done = subprocess.run([sys.executable, "-c", code, str(out)], capture_output=True, text=True)
    assert done.stdout.strip() == "1" and not done.stderr, done.stderr
    # gone with the process
    assert not list(out.iterdir())


@pytest.mark.parametrize("given", ["file/none", "not/there"])
def test_a_folder_for_fonts_that_was_given_is_looked_at(given: str, bare: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MPLCONFIGDIR", str(bare / given))
    kept.ensure()
    assert (os.environ["MPLCONFIGDIR"] == str(bare / given)) == (given == "not/there")


def test_fonts_beside_does_nothing_where_a_folder_lasts(bare: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MPLCONFIGDIR", str(bare / "lasts"))
    kept.fonts_beside(bare / "x.png")
    assert os.environ["MPLCONFIGDIR"] == str(bare / "lasts") and not list(bare.glob(".sstl-fonts-*"))


def test_a_relative_home_is_none(bare: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # a user without an entry in the list of users: "~" stays as it is
    assert not kept._can_make(Path("~/.cache/numba"))


def test_a_folder_that_is_gone_keeps_no_program_from_starting(bare: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    gone = bare / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    found = kept.ensure()
    assert found.folder == bare / f"sstl-{os.getuid()}" / "compiled"
    monkeypatch.setattr(kept, "_keeps_fonts", lambda: False)
    kept.fonts_beside(bare / "x.png")
    assert os.environ["MPLCONFIGDIR"].startswith(str(bare / ".sstl-fonts-"))


def test_a_home_that_cannot_be_looked_into_is_none(bare: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(self: Path) -> bool:
        raise PermissionError(13, "Permission denied", str(self))

    monkeypatch.setattr(Path, "exists", refused)
    assert not kept._can_make(bare / "home" / ".cache" / "numba")
    monkeypatch.undo()
    # nor is one whose name no file system takes
    assert not kept._can_make(bare / ("x" * 300) / "numba")


@pytest.mark.slow
@pytest.mark.skipif(ROOT_USER and not shutil.which("setpriv"), reason="root can write anywhere")
def test_a_service_user_on_a_read_only_tree(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "sstl_cli", tmp_path / "sstl_cli", ignore=shutil.ignore_patterns("__pycache__"))
    temporary = tmp_path / "tmp"
    temporary.mkdir()
    for path in (tmp_path / "sstl_cli").rglob("*"):
        path.chmod(path.stat().st_mode & 0o555)
    (tmp_path / "sstl_cli").chmod(0o555)
    plain = "-dac_override,-dac_read_search"
    before = ["setpriv", "--bounding-set", plain, "--inh-caps", plain] if ROOT_USER else []
    log, out = ROOT / "data/samples/log.parquet", temporary / "t.parquet"
    for words in (["doctor"], ["segment", log, "--out", out], ["plot", out, "--out", temporary / "t.png"]):
        done = subprocess.run(
            [*before, sys.executable, "-m", "sstl_cli", *map(str, words)], cwd=tmp_path, capture_output=True, text=True,
            env={"PATH": os.environ["PATH"], "TMPDIR": str(temporary), "HOME": "/proc/none", "PYTHONPATH": str(tmp_path)},
        )  # fmt: skip
        assert (done.returncode, done.stderr) == (0, ""), done.stdout
    assert list((temporary / f"sstl-{os.getuid()}" / "compiled").rglob("*.nbi"))
