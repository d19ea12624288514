"""Which files the subcommand of a batch reads beside its input: named by its options, by ``SSTL_*`` values or by a ``--config`` file."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from sstl_cli.core.errors import UsageError, nearest
from sstl_cli.steps.batch import EXPORT_SUFFIXES, FORMS, STEM, Form, Item


def require_outputs_of_its_own(parsed: Any, form: Form, out: str) -> None:
    """Refuse outputs that are not those of one file: ``-oNAME`` after ``--``, side outputs or formats that only a variable names.

    Parameters
    ----------
    parsed : context of typer
        The subcommand with its options, as parsed for one file.
    out : str
        The output that it was told.
    """
    for parameter in parsed.command.params:
        value, source = parsed.params.get(parameter.name), parsed.get_parameter_source(parameter.name)
        if "--out" in parameter.opts and not form.printed and str(value) != out:
            fix = "sstl batch names the outputs itself; give --out-dir before --"
            raise UsageError(f"'{value}' would be one output for all", where="after --", fix=fix, code="E021")
        if form is FORMS["export"] and "--format" in parameter.opts and EXPORT_SUFFIXES.get(str(value)) != Path(out).suffix:
            fix = f"write it after -- as --format {value}" if value in EXPORT_SUFFIXES else nearest(str(value), EXPORT_SUFFIXES)
            raise UsageError(f"'{value}' is not the format that names the outputs", where="--format", fix=fix, code="E021")
        if set(parameter.opts) & set(form.side) and value is not None and source is not None and source.name != "COMMANDLINE":
            name = parameter.opts[0]
            fix = f"give {name} after --, with a name such as {STEM}-{Path(str(value)).name}"
            raise UsageError(f"'{value}' would be one file for all", where=name, fix=fix, code="E025")


def named_files(values: Mapping[str, object], item: Item) -> tuple[str, ...]:
    """Return the files that the values of a subcommand's options name, without its input and outputs.

    Parameters
    ----------
    values : dict
        Value of each option but its outputs, wherever it came from, as typer parsed it for ``item``.
    """
    texts = (str(t) for v in values.values() for t in (v if isinstance(v, (list, tuple)) else [v]) if isinstance(t, (str, Path)))
    found = [t for t in texts if t != item.source and 0 < len(t) < 4096 and "\0" not in t and os.path.isfile(t)]
    return tuple(dict.fromkeys([*found, *_manifests(values.get("mapping"))]))


def _manifests(mapping: object) -> Iterator[str]:
    """Yield the table of labels that a mapping names; what is wrong with the mapping is for the import to say."""
    from sstl_cli.core.config import read_toml
    from sstl_cli.core.errors import SstlError

    if not isinstance(mapping, Path):
        return
    try:
        manifest = read_toml(mapping).get("manifest")
    except SstlError:
        return
    if isinstance(manifest, str) and manifest and os.path.isfile(mapping.parent / manifest):
        yield str(mapping.parent / manifest)
