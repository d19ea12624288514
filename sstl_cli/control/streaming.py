"""The controller on a stream of text lines: each sample answered at once, every loss of input logged."""

from __future__ import annotations

import json
import math
import os
import select
from collections.abc import Callable, Iterator

from sstl_cli.control.controller import Controller

MAX_LINE_BYTES = 65_536
CSV_HEADER = ("t_ref", "t_in")
ANSWER_HEADER = ("t_cmd", "phase")


class LineServer:
    """Answers lines ``t_ref,t_in`` or ``{"t_ref": .., "t_in": ..}`` with command and phase in the same form.

    Parameters
    ----------
    controller : Controller
        Advanced by one sample for every line that is not a header.
    log : callable
        Takes one sentence each time the input is lost, changes its fault, or is sound again.
    """

    def __init__(self, controller: Controller, log: Callable[[str], None]) -> None:
        self.controller, self.log = controller, log
        self.lines = 0
        self.faulty_samples = 0
        self._fault = ""
        self._json = False

    def answer(self, line: str) -> str:
        """Return the answer to one line (without line end)."""
        self.lines += 1
        text = line.strip()
        header = tuple(w.strip().lower() for w in text.split(",")) == CSV_HEADER
        # a line that cannot be read is answered in the form of those before it
        if header or not read_csv_sample(text)[2]:
            self._json = False
        elif text.startswith(("{", "[")):
            self._json = True
        if header:
            return ",".join(ANSWER_HEADER)
        t_ref, t_in, why = read_json_sample(text) if self._json else read_csv_sample(text)
        return self._step(t_ref, t_in, why)

    def silence(self, seconds: float) -> str:
        """Return the safe command for an input that has been silent for ``seconds``."""
        for _ in range(max(round(seconds / self.controller.options.dt_s) - 1, 0)):
            self.controller.step(math.nan, math.nan)
        return self._step(math.nan, math.nan, "no line arrived in time")

    def _step(self, t_ref: float, t_in: float, why: str) -> str:
        command, phase = self.controller.step(t_ref, t_in)
        fault = why or self.controller.fault
        if fault != self._fault:
            now = f"{fault}: holding, then ramping down" if fault else "input sound again: returning at the ramp's rate"
            self.log(f"line {self.lines}: {now}")
            self._fault = fault
        self.faulty_samples += bool(fault)
        if self._json:
            return json.dumps({"t_cmd": command, "phase": phase})
        return f"{command!r},{phase}"


def read_csv_sample(text: str) -> tuple[float, float, str]:
    """Return reference, measured tension (N), and why the line cannot be used (empty if it can)."""
    words = text.split(",")
    if len(words) != 2:
        return math.nan, math.nan, f"{len(words)} values instead of 2" if text else "empty line"
    try:
        return float(words[0]), float(words[1]), ""
    except ValueError:
        return math.nan, math.nan, "a value is not a number"


def read_json_sample(text: str) -> tuple[float, float, str]:
    """Return reference, measured tension (N), and why the line cannot be used (empty if it can)."""
    try:
        document = json.loads(text)
    except (ValueError, RecursionError):
        return math.nan, math.nan, "not valid JSON"
    if not isinstance(document, dict):
        return math.nan, math.nan, "not a JSON object"
    values = []
    for key in CSV_HEADER:
        value = document.get(key)
        if value is not None and (isinstance(value, bool) or not isinstance(value, (int, float))):
            return math.nan, math.nan, f"{key} is not a number"
        try:
            values.append(math.nan if value is None else float(value))
        except OverflowError:
            values.append(math.inf)
    return values[0], values[1], ""


def read_lines(descriptor: int, timeout_s: float | None = None) -> Iterator[str | None]:
    """Yield lines as they arrive, None each time none came within ``timeout_s``; a line too long is cut.

    Reads the descriptor itself: buffered text input cannot be waited for with a timeout.
    """
    pending = b""
    while True:
        if timeout_s is not None and not select.select([descriptor], [], [], timeout_s)[0]:
            yield None
            continue
        block = os.read(descriptor, MAX_LINE_BYTES)
        if not block:
            break
        *lines, pending = (pending + block).split(b"\n")
        for line in lines:
            yield line[:MAX_LINE_BYTES].decode("utf-8", "replace")
        pending = pending[:MAX_LINE_BYTES]
    if pending:
        yield pending.decode("utf-8", "replace")
