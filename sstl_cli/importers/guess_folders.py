"""Labels that only the folders of recordings tell."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from sstl_cli.importers.guess_files import Named, label_words, shared_labels
from sstl_cli.importers.systems import SYSTEM_OF

# folders that a question names, and above a file those that are looked at
SHOWN = 3


def with_folders(named: Named, paths: Sequence[Path]) -> Named:
    """Return the labels of files with those that only their folders tell, which are asked: of several as configurations, of one what its name says.

    Examples
    --------
    >>> with_folders(Named(), [Path("bend30/a.csv"), Path("bend60/a.csv")]).constants
    (('config_id', '{folder}'),)
    >>> with_folders(Named(), [Path("sstl_bend30/a.csv")]).constants
    (('system', 'sstl'), ('config_id', '30'))
    """
    folders = sorted({p.absolute().parent.name for p in paths})
    told = {*named.labels, *dict(named.constants)}
    if told & {"config_id", "lead_mm"}:
        return named
    if len(folders) == 1:
        own, named_by = _of_one(paths[0], told)
        asked = f"its folder {named_by} says so: does it hold for these files?" if own else ""
        labels = (*named.labels, *(k for k, _ in own))
        return replace(named, labels=labels, question="; ".join(filter(None, (named.question, asked))), constants=(*named.constants, *own))
    if len({p.name for p in paths}) == len(paths) and "config_id" not in label_words(folders):
        return named
    question = f"does the folder ({', '.join(folders[:SHOWN])}) tell the bending configuration? If not, take config_id out"
    words = (w.lower() for p in paths for part in p.absolute().parts[:-1][-SHOWN:] for w in re.findall("[A-Za-z]+", part))
    systems = {SYSTEM_OF[w] for w in words if w in SYSTEM_OF}
    if "system" not in told and len(systems) > 1:
        question += "; and folders say both systems: import the files of each by themselves"
    asked = "; ".join(filter(None, (named.question, question)))
    return replace(named, question=asked, constants=(*named.constants, ("config_id", "{folder}")))


def _of_one(path: Path, told: set[str]) -> tuple[list[tuple[str, str]], str]:
    """Return the labels that words in the names of the folders above a file tell, the nearest first, and these names; not those that are told already."""
    own: dict[str, str] = {}
    shown: list[str] = []
    for folder in path.absolute().parts[:-1][::-1][:SHOWN]:
        found = {k: v for k, v in shared_labels([folder]).constants if k in ("system", "config_id") and k not in {*told, *own}}
        sure = label_words([folder]) if found else set()
        if found := {k: v for k, v in found.items() if k in sure}:
            own |= found
            shown.append(repr(folder))
    return list(own.items()), " and ".join(shown)
