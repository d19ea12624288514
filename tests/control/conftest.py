"""The program as a user calls it."""

from __future__ import annotations

import sys

import pytest

from sstl_cli.cli.app import main


@pytest.fixture
def sstl(monkeypatch, capsys):
    def call(*args):
        monkeypatch.setattr(sys, "argv", ["sstl", *map(str, args)])
        with pytest.raises(SystemExit) as ended:
            main()
        shown = capsys.readouterr()
        return ended.value.code or 0, shown.out, shown.err

    return call
