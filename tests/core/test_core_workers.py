"""Folders of a program that is gone do not outlive it, even while they are written into."""

from __future__ import annotations

from pathlib import Path

import pytest

from sstl_cli.core import workers


def test_a_folder_that_is_written_into_is_removed_all_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    work, tries = tmp_path / "work-1", []
    work.mkdir()
    real = workers.shutil.rmtree

    def rmtree(folder: Path, ignore_errors: bool) -> None:
        real(folder, ignore_errors=ignore_errors)
        tries.append(folder)
        if len(tries) < 3:
            # its owner was in the middle of writing
            work.mkdir(exist_ok=True)

    monkeypatch.setattr(workers.shutil, "rmtree", rmtree)
    with workers.at_work_in(work):
        workers._remove_begun()
    assert not work.exists()
    assert len(tries) == 3
