"""Where the outputs of a call come from: its command line, inputs, configuration file and SSTL_* values."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sstl_cli.core.provenance import Provenance

# how often a file is made, how it is shown and how many work on it decide no byte of it
_NO_MATTER = {"force", "as_json", "json_", "workers"}


@dataclass(frozen=True)
class _Call:
    """The context and the configuration file of a command."""

    context: Any = None
    config: Path | None = None


# the one that runs
_calls = [_Call()]


def remember(context: Any, config: Path | None) -> None:
    """Keep what ``provenance`` needs of the call; the option ``--config`` is parsed first in every command."""
    _calls[0] = _Call(context, config)


def provenance(seed: int | None, files: list[Path], extra: dict[str, object] | None = None) -> Provenance:
    """Return the provenance of an output of this call.

    Parameters
    ----------
    seed : int or None
        Seed of the random numbers.
    files : list of Path
        The inputs; the configuration file is added where one was given.
    extra : dict, optional
        What else is worth keeping.
    """
    from sstl_cli.core.provenance import Provenance

    values = environment()
    return Provenance(command_line(), seed, inputs(files), {**(extra or {}), **({"environment": values} if values else {})})


def inputs(files: list[Path]) -> dict[str, str]:
    """Return the SHA-256 of inputs and configuration file by name."""
    from sstl_cli.core.provenance import inputs_of

    config = _calls[0].config
    return inputs_of([*files, *([config] if config is not None else [])])


def environment() -> dict[str, str]:
    """Return the SSTL_* values that this command took, by name, folders removed from paths."""
    context = _calls[0].context
    if context is None:
        return {}
    taken = {}
    for parameter in context.command.params:
        source = context.get_parameter_source(parameter.name)
        if source is not None and source.name == "ENVIRONMENT" and parameter.name not in _NO_MATTER:
            name = str(parameter.envvar)
            taken[name] = " ".join(without_folder(word) for word in os.environ.get(name, "").split())
    return dict(sorted(taken.items()))


def refuse(what: str, options: Iterable[str], fix: str = "leave it out") -> None:
    """Raise UsageError for those of the options that were typed, where ``what`` is asked for and has nothing for them.

    They would be read and left without effect. In a configuration file or a variable they are defaults of many calls.

    Parameters
    ----------
    what : str
        What the call asks for, to begin the message with.
    options : iterable of str
        Long names, such as ``--dt``.
    """
    from sstl_cli.core.errors import UsageError

    context = _calls[0].context
    names, typed = set(options), []
    for parameter in context.command.params if context else ():
        source = context.get_parameter_source(parameter.name)
        if names & set(parameter.opts) and source is not None and source.name == "COMMANDLINE":
            typed.append(next(o for o in parameter.opts if o in names))
    if typed:
        raise UsageError(f"{what} has nothing for {', '.join(typed)}", fix=fix, code="E006")


def files_among(*given: Path | str | None) -> list[Path]:
    """Return those of the given names that are files: a scenario may be one, or come with the package."""
    return [Path(g) for g in given if g is not None and Path(g).is_file()]


def command_line() -> str:
    """Return the command line for provenance: what decides the bytes of the output, folders removed.

    Folders are dropped so that the same inputs in another folder give the same bytes; so is how often a file was
    made (``--force``), how it was shown (``--json``, ``--quiet``, ``--verbose``) and how many worked on it (``--workers``).
    """
    words, given = ["sstl"], iter(sys.argv[1:])
    for word in given:
        name, equals, value = word.partition("=") if word.startswith("--") else ("", "", word)
        if word in ("--force", "--json", "--quiet", "-q", "--verbose", "-v"):
            continue
        if name == "--workers":
            if not equals:
                next(given, None)
            continue
        if name == "--map":
            # its /patterns/ are not paths
            words += [word] if equals else [word, next(given, "")]
            continue
        words.append(f"{name}{equals}{without_folder(value)}")
    return " ".join(words)


def without_folder(word: str) -> str:
    """Return a path without its folders; addresses and other words as they are."""
    return Path(word).name if "/" in word and "://" not in word else word
