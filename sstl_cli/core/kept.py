"""Where compiled functions and font lists are kept where neither the installation nor the home folder can be written.

Containers and service users often have no usable home; without a folder numba refuses to start, and matplotlib complains.
"""

from __future__ import annotations

import atexit
import os
import shutil
import stat
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from sstl_cli.core.compiled import guard

PACKAGE = Path(__file__).parents[1]


@dataclass(frozen=True)
class Kept:
    """Where compiled functions are kept: a folder, or None where each start compiles anew; and why it is that one.

    ``as_asked`` is False where the user named another.
    """

    folder: Path | None
    why: str = ""
    as_asked: bool = True


@cache
def at_start() -> Kept:
    """Return what was chosen when the package was imported; what numba is told then hides what the user asked for."""
    return ensure()


def ensure() -> Kept:
    """Choose the folder, and tell numba and matplotlib before they are imported; costs a few system calls."""
    guard()
    if os.name != "posix":
        return Kept(PACKAGE)
    home = Path(os.path.expanduser("~"))
    caches = Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache")
    if not _keeps_fonts():
        fonts = private("fonts")
        if fonts is not None:
            os.environ["MPLCONFIGDIR"] = str(fonts)
    given = os.environ.get("NUMBA_CACHE_DIR")
    if given and _can_make(Path(given)):
        return Kept(Path(given), "NUMBA_CACHE_DIR")
    refused, as_asked = f"NUMBA_CACHE_DIR={given} cannot be written" if given else "", not given
    # numba takes each module's own folder where it can, else the user's: one of them is enough, and this is quick to ask
    if _can_make(caches / "numba"):
        return Kept(PACKAGE if os.access(PACKAGE, os.W_OK) else caches / "numba", refused, as_asked)
    if _tree_writable():
        return Kept(PACKAGE, refused, as_asked)
    folder = private("compiled")
    why = "; ".join(filter(None, (refused, "neither the installation nor the home folder can be written")))
    if folder is None:
        _keep_nothing()
        return Kept(None, f"{why}, nor a folder for temporary files: every start compiles anew", as_asked)
    os.environ["NUMBA_CACHE_DIR"] = str(folder)
    return Kept(folder, f"{why}: kept until the temporary files are cleared", as_asked)


def fonts_beside(output: Path | None = None) -> None:
    """Give matplotlib a folder for the time of this process where none lasts: beside the output, else where the call was made.

    To be called before matplotlib is imported: without a folder it complains, or does not start.
    """
    import tempfile

    if os.name != "posix" or _keeps_fonts():
        return
    for parent in filter(None, (output and Path(output).resolve().parent, _here())):
        try:
            folder = tempfile.mkdtemp(prefix=".sstl-fonts-", dir=parent)
        except OSError:
            continue
        os.environ["MPLCONFIGDIR"] = folder
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        return


def _keeps_fonts() -> bool:
    """Whether matplotlib finds folders it can write: the one it is told of, else those of the user."""
    home = Path(os.path.expanduser("~"))
    told = os.environ.get("MPLCONFIGDIR")
    usual = (os.environ.get("XDG_CONFIG_HOME") or home / ".config", os.environ.get("XDG_CACHE_HOME") or home / ".cache")
    return all(_can_make(folder) for folder in ([Path(told).absolute()] if told else [Path(u, "matplotlib") for u in usual]))


def private(name: str) -> Path | None:
    """Return a folder among the temporary files that only this user can write, or None.

    What is kept there will be run: a folder of somebody else under that name is not taken.
    """
    import tempfile

    try:
        root = Path(tempfile.gettempdir())
        if root == _here():
            return None
        folder = root / f"sstl-{os.getuid()}"
        for path in (folder, folder / name):
            path.mkdir(mode=0o700, exist_ok=True)
            found = path.lstat()
            if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid() or found.st_mode & 0o022:
                return None
    except OSError:
        return None
    return folder / name


def _here() -> Path | None:
    """Return the folder that the call was made in; None where it was removed meanwhile."""
    try:
        return Path.cwd()
    except OSError:
        return None


def _tree_writable() -> bool:
    """Whether every folder of the package can take compiled functions."""
    folders = [Path(folder) for folder, _, files in os.walk(PACKAGE) if any(f.endswith(".py") for f in files)]
    kept = [f / "__pycache__" for f in folders]
    return all(os.access(k if k.is_dir() else f, os.W_OK) for f, k in zip(folders, kept, strict=True))


def _can_make(folder: Path) -> bool:
    """Whether a folder can be written, or made and written."""
    if not folder.is_absolute():
        return False
    try:
        while not folder.exists():
            folder = folder.parent
    except OSError:
        # below a folder of somebody else, such as the home that a service was started from
        return False
    return folder.is_dir() and os.access(folder, os.W_OK | os.X_OK)


def _keep_nothing() -> None:
    """Let numba compile without keeping anything."""
    from numba.core.dispatcher import Dispatcher

    # numba has no setting for "no cache"; a function marked for it would stop the import
    setattr(Dispatcher, "enable_caching", lambda self: None)  # noqa: B010
