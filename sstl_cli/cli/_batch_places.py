"""Files of a batch on any file system fsspec knows: local folders, object stores, memory."""

from __future__ import annotations

import hashlib
import json
import os
import secrets
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sstl_cli.core.errors import SstlError

WORK = ".batch"


@dataclass(frozen=True)
class Place:
    """A file or folder: its address as given, the file system and the path inside it."""

    url: str
    fs: Any
    path: str

    @property
    def local(self) -> bool:
        """Whether the path is one of this machine's own files."""
        return "file" in _protocols(self.fs)

    @property
    def own(self) -> bool:
        """Whether only this process can see it (``memory://``)."""
        return "memory" in _protocols(self.fs)

    def inside(self, *names: str) -> Place:
        """Return a file below this folder."""
        return Place("/".join([self.url.rstrip("/"), *names]), self.fs, "/".join([self.path.rstrip("/"), *names]))

    def exists(self) -> bool:
        """Return whether there is a file."""
        return bool(self.fs.isfile(self.path))

    def sha256(self) -> str | None:
        """Return the SHA-256 as hexadecimal text, None where there is no file."""
        if not self.exists():
            return None
        digest = hashlib.sha256()
        with self.fs.open(self.path, "rb") as file:
            while block := file.read(1 << 20):
                digest.update(block)
        return digest.hexdigest()


def place(url: str, root: str = "") -> Place:
    """Return the place of an address (a path: below ``root``); SstlError where its file system cannot be used."""
    from fsspec.core import url_to_fs

    try:
        fs, path = url_to_fs(os.path.abspath(os.path.join(root, url)) if "://" not in url else url)
    except (ImportError, ValueError) as error:
        raise SstlError(f"its file system cannot be used ({str(error)[:120]})", where=url, fix="install its package", code="E030") from None
    return Place(url, fs, path)


def expand(urls: list[str]) -> list[str]:
    """Return the addresses with ``*`` and ``?`` of remote ones filled in, in the order of their names."""
    found: list[str] = []
    for url in urls:
        if not any(c in url for c in "*?[") or ("://" not in url and Path(url).exists()):
            found.append(url)
            continue
        at = place(url)
        with telling(url):
            matches = sorted(at.fs.glob(at.path))
        if not matches:
            raise SstlError("no file fits the pattern", where=url, fix="check the pattern", code="E031")
        found += [m if "://" not in url else at.fs.unstrip_protocol(m) for m in matches]
    return found


@contextmanager
def telling(where: str) -> Iterator[None]:
    """Turn whatever a file system raises into one SstlError."""
    try:
        yield
    except SstlError:
        raise
    except Exception as error:
        # fsspec drivers raise errors of their own libraries, with no common base below Exception
        text = " ".join(f"{type(error).__name__}: {error}".split())[:160]
        raise SstlError(f"cannot be reached ({text})", where=where, fix="check path, space and rights", code="E032") from None


def publish(staged: Path, target: Place) -> None:
    """Give a finished local file its name in the output folder, whole or not at all."""
    with telling(target.url):
        if target.local:
            os.replace(staged, os.path.realpath(target.path))
            return
        folder, _, name = target.path.rpartition("/")
        temporary = f"{folder}/.{name}.{secrets.token_hex(4)}.tmp"
        target.fs.put_file(str(staged), temporary)
        target.fs.mv(temporary, target.path)


def write_record(target: Place, record: Mapping[str, object]) -> None:
    """Write what is known about an output (small, whole or not at all)."""
    body = (json.dumps(record, indent=1, sort_keys=True) + "\n").encode()
    with telling(target.url):
        if target.local:
            temporary = Path(f"{target.path}.{secrets.token_hex(4)}.tmp")
            try:
                with open(temporary, "wb") as file:
                    file.write(body)
                    file.flush()
                    os.fsync(file.fileno())
                os.replace(temporary, target.path)
            finally:
                temporary.unlink(missing_ok=True)
        else:
            target.fs.pipe_file(target.path, body)


def read_record(target: Place) -> object:
    """Return what is written down about an output, None where there is nothing that can be read."""
    with telling(target.url):
        if not target.exists():
            return None
        body = target.fs.cat_file(target.path)
    try:
        return json.loads(body)
    except (ValueError, RecursionError):
        return None


def _protocols(fs: Any) -> tuple[str, ...]:
    return (fs.protocol,) if isinstance(fs.protocol, str) else tuple(fs.protocol)
