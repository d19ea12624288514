"""One subcommand over many files: names of the outputs, what a resumed batch may skip, and the account at the end."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import PurePosixPath
from typing import get_args

from sstl_cli import __version__
from sstl_cli.core.documents.outputs import BatchDocument, BatchResult, State
from sstl_cli.core.errors import EXIT_DONE, EXIT_FAILED, EXIT_GATE, EXIT_SET_ASIDE, SstlError, UsageError, nearest

RECORD = "sstl.batch-record/1"
STARTED, DONE = "started", "done"
STEM = "{name}"


@dataclass(frozen=True)
class Form:
    """How a subcommand takes one file and gives one file.

    ``option`` names the option that takes the input ("" for an argument); ``printed`` says that the output is the
    JSON document on stdout; ``side`` lists options that name further outputs.
    """

    suffix: str
    option: str = ""
    printed: bool = False
    side: tuple[str, ...] = ()


FORMS: dict[str, Form] = {
    "simulate": Form(".parquet", option="--scenario"),
    "import": Form(".parquet"),
    "check": Form(".json", printed=True),
    "info": Form(".json", printed=True),
    "segment": Form(".parquet", side=("--phases",)),
    "train": Form(".safetensors", side=("--history",)),
    "evaluate": Form(".parquet", side=("--predictions",)),
    "compensate": Form(".parquet", option="--theta", side=("--scores",)),
    "diagnose": Form(".json", side=("--save-sim", "--next-out", "--junit", "--summary")),
    "report": Form(".html"),
    "plot": Form(".svg"),
    "export": Form(".json"),
}
EXPORT_SUFFIXES = {"json": ".json", "onnx": ".onnx", "csv": ".csv", "mat": ".mat", "mcap": ".mcap"}


@dataclass(frozen=True)
class Item:
    """One file of a batch: where it lies, the name of its output, and the words that follow the subcommand."""

    source: str
    output: str
    options: tuple[str, ...]
    side: tuple[str, ...] = ()


@dataclass(frozen=True)
class Outcome:
    """What became of one file."""

    source: str
    output: str
    state: State
    exit_code: int
    line: str = ""
    outputs: Mapping[str, str] = field(default_factory=dict)


def form_of(command: str, options: Sequence[str]) -> Form:
    """Return how ``command`` is run over files; UsageError where it cannot be.

    Raises
    ------
    UsageError
        If the subcommand is unknown or does not turn one file into one file, or the options name the output.
    """
    if command not in FORMS:
        raise UsageError(f"cannot run '{command}' over files ({nearest(command, FORMS)})", where="COMMAND", code="E020")
    for word in options:
        if word.partition("=")[0] in ("--out", "-o", "--json", "--force", "--help", "-h"):
            raise UsageError(
                f"'{word}' is not an option for each file",
                where="after --",
                fix="sstl batch names the outputs itself; give --out-dir, --force and --json before --",
                code="E021",
            )
    form = FORMS[command]
    if command == "export":
        wanted = _value(options, "--format", "-f") or "json"
        if wanted not in EXPORT_SUFFIXES:
            raise UsageError(f"'{wanted}' is not one file", where="--format", fix=nearest(wanted, EXPORT_SUFFIXES), code="E021")
        form = Form(EXPORT_SUFFIXES[wanted])
    return form


def plan(command: str, sources: Sequence[str], options: Sequence[str]) -> list[Item]:
    """Return the items of a batch in the order given.

    Raises
    ------
    UsageError
        If two files would give one output, or an option names one side output for all files.
    """
    form = form_of(command, options)
    items: list[Item] = []
    taken: dict[str, str] = {}
    for source in sources:
        stem = PurePosixPath(source.rstrip("/").rpartition("/")[2]).stem
        words, side = _named(options, stem, form)
        item = Item(source, stem + form.suffix, words, side)
        for name in (item.output, *side):
            if name in taken:
                raise UsageError(
                    f"would give the same output '{name}' as {taken[name]}",
                    where=source,
                    fix="give them in two batches with an --out-dir each",
                    code="E022",
                )
            taken[name] = source
        items.append(item)
    return items


@dataclass(frozen=True)
class Record:
    """What is noted beside an output: what decides its bytes and, once it is there, how the call that made it ended."""

    command: str
    options: tuple[str, ...]
    version: str
    inputs: Mapping[str, str]
    environment: Mapping[str, str]
    state: str = STARTED
    exit_code: int = EXIT_DONE
    line: str = ""
    outputs: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, document: object) -> Record | None:
        """Return the record that a document is, None where it is none."""
        if not isinstance(document, dict) or document.get("schema") != RECORD:
            return None

        def texts(name: str) -> dict[str, str]:
            found = document.get(name)
            return found if isinstance(found, dict) else {}

        options, code = document.get("options"), document.get("exit_code", EXIT_DONE)
        return cls(
            command=str(document.get("command")),
            options=tuple(map(str, options)) if isinstance(options, list) else (),
            version=str(document.get("version")),
            inputs=texts("inputs"),
            environment=texts("environment"),
            state=str(document.get("state")),
            exit_code=code if isinstance(code, int) else EXIT_FAILED,
            line=str(document.get("line", "")),
            outputs=texts("outputs"),
        )

    def document(self) -> dict[str, object]:
        """Return what is written down; how a call ended only once it has."""
        ended = {"exit_code": self.exit_code, "line": self.line, "outputs": dict(self.outputs)}
        return {
            "schema": RECORD,
            "command": self.command,
            "options": list(self.options),
            "version": self.version,
            "inputs": dict(self.inputs),
            "environment": dict(self.environment),
            "state": self.state,
            **(ended if self.state == DONE else {}),
        }


def decide(record: Record | None, wanted: Record, present: Mapping[str, str | None], force: bool, where: str) -> bool:
    """Return whether a file is to be run (False: its outputs are complete already).

    Parameters
    ----------
    record : Record or None
        What an earlier batch noted about these outputs.
    wanted : Record
        What this batch would note: command, options, version and the SHA-256 of the inputs.
    present : dict
        SHA-256 of each output that exists; None for one that does not.
    force : bool
        Run whatever there is.
    where : str
        The output, for the error.

    Raises
    ------
    SstlError
        If an output exists that no batch made, or a batch of another command or other options.
    """
    there = {name: digest for name, digest in present.items() if digest is not None}
    if force or not there:
        return True
    if record is None:
        raise SstlError("exists already and no batch made it", where=where, fix="use --force or another --out-dir", code="E023")
    if record.state != DONE:
        return True
    if (record.command, record.options) != (wanted.command, wanted.options):
        raise SstlError(
            "was made by another command or with other options", where=where, fix="use --force or another --out-dir", code="E024"
        )
    if (record.inputs, record.version, record.environment) != (wanted.inputs, wanted.version, wanted.environment):
        return True
    return record.outputs != there


def wanted_record(command: str, item: Item, inputs: Mapping[str, str], environment: Mapping[str, str]) -> Record:
    """Return the record of a call that begins: what decides the bytes of the outputs."""
    return Record(command, item.options, __version__, inputs, environment)


def exit_code(outcomes: Sequence[Outcome]) -> int:
    """Return the exit code: 1 nothing worked, 4 a gate missed, 3 something failed or was set aside, 0 done."""
    states = [o.state for o in outcomes]
    if all(s == "failed" for s in states):
        return EXIT_FAILED
    if "gate" in states:
        return EXIT_GATE
    return EXIT_SET_ASIDE if any(o.exit_code for o in outcomes) else EXIT_DONE


def counts(outcomes: Sequence[Outcome]) -> dict[State, int]:
    """Return how many files ended in each state."""
    return {state: sum(o.state == state for o in outcomes) for state in get_args(State)}


def document(command: str, out_dir: str, options: Sequence[str], outcomes: Sequence[Outcome]) -> BatchDocument:
    """Return the account of a batch."""
    count = counts(outcomes)
    return BatchDocument(
        schema="sstl.batch/1",
        command=command,
        options=list(options),
        out_dir=out_dir,
        files=len(outcomes),
        done=count["done"],
        skipped=count["skipped"],
        set_aside=count["set_aside"],
        gate_missed=count["gate"],
        failed=count["failed"],
        results=[
            BatchResult(input=o.source, output=o.output, state=o.state, exit_code=o.exit_code, line=o.line, sha256=o.outputs.get(o.output))
            for o in outcomes
        ],
    )


def _named(options: Sequence[str], stem: str, form: Form) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the options with ``{name}`` filled in, and the names of the side outputs among them."""
    words: list[str] = []
    side: list[str] = []
    after = ""
    for word in options:
        option, equals, value = word.partition("=") if word.startswith("--") else ("", "", word)
        owner = option if equals else after
        if (equals or not option) and owner in form.side:
            if STEM not in value or "/" in value:
                raise UsageError(
                    f"'{value}' would be one file for all",
                    where=owner,
                    fix=f"write a name with {STEM}, such as {STEM}.extra; it is put into --out-dir",
                    code="E025",
                )
            value = value.replace(STEM, stem)
            side.append(value)
        words.append(f"{option}{equals}{value}" if equals else value if not option else word)
        after = option if option and not equals else ""
    return tuple(words), tuple(side)


def _value(options: Sequence[str], *names: str) -> str | None:
    for i, word in enumerate(options):
        head, equals, value = word.partition("=")
        if head in names:
            return value if equals else (options[i + 1] if i + 1 < len(options) else None)
    return None
