"""A proposed mapping for an unknown recording: what each channel seems to be, why, and a preview loop."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sstl_cli.core.errors import SstlError
from sstl_cli.core.units import unit_of
from sstl_cli.importers.base import Channel, Format, Layout, Notes, detect, guarded
from sstl_cli.importers.mapping import REQUIRED

Array = NDArray[np.float64]
MAX_ROWS = 20_000
MAX_COLUMNS = 64
_TIME = re.compile(r"(^|[^a-z])(t|time|zeit|stamp|timestamp|sec|seconds)([^a-z]|$)", re.I)
_INPUT = re.compile(r"(^|[^a-z])(in|input|prox|proximal|motor|drive|pull)([^a-z]|$)|tension_?1|force_?1", re.I)
_OUTPUT = re.compile(r"(^|[^a-z])(out|output|dist|distal|tip|end|load)([^a-z]|$)|tension_?2|force_?2", re.I)
_TENSION = re.compile(r"tension|force|load|newton", re.I)
_POSITION = re.compile(r"pos|displ|stroke|travel", re.I)


@dataclass(frozen=True)
class Guess:
    """A mapping to be edited, with its reasons and a preview of the loop."""

    format: str
    toml: str
    reasons: list[str]
    preview: list[str]


def guess(path: Path, wanted: str | None = None) -> Guess:
    """Return a proposed mapping from names, units and the first 20 000 samples.

    Raises
    ------
    SstlError
        If the file cannot be read, or holds fewer than two numeric channels.
    """
    chosen = detect(path, wanted)
    channels = [c for c in chosen.channels(path, Layout()) if not c.text][:MAX_COLUMNS]
    reasons = [f"format {chosen.ID}: {chosen.TITLE}, {len(channels)} numeric channels"]
    names = {c.name for c in channels}
    if all(n in names for n in REQUIRED):
        reasons.append("the columns are canonical: no mapping is needed")
    data = {c.name: v for c in channels if (v := _first_values(chosen, path, c)) is not None and len(v) > 2}
    if len(data) < 2:
        raise SstlError("holds fewer than two numeric channels", where=str(path), fix="check the file", code="E333")
    time, unit = _time(channels, data, reasons)
    usable = [
        c
        for c in channels
        if c.name in data and c.name != time and len(data[c.name]) == _common(data) and np.ptp(data[c.name]) > 0
    ]
    first: Channel | None
    second: Channel | None
    against = _antagonists(usable, data, reasons)
    if against:
        net = Channel(" - ".join(c.name for c in against))
        data[net.name] = data[against[0].name] - data[against[1].name]
        others = [c for c in usable if c not in against]
        first, second = net, _follows(data[net.name], others, data, reasons)
    else:
        first, second = _pair(usable, data, reasons)
    toml = _toml(chosen, channels, time, unit, first, second, usable, against)
    preview = loop(data[first.name], data[second.name]) if first and second else []
    if preview and first and second:
        preview = [f"{second.name} (up) over {first.name} (right):", *preview]
    return Guess(chosen.ID, toml, reasons, preview)


def _first_values(chosen: Format, path: Path, channel: Channel) -> Array | None:
    out: list[Array] = []
    rows = 0
    with guarded(path, chosen.TITLE):
        try:
            for block in chosen.read(path, [channel.name], [], Layout(), Notes()):
                out.append(np.asarray(block.columns[channel.name], np.float64))
                rows += len(out[-1])
                if rows >= MAX_ROWS:
                    break
        except SstlError as error:
            # one channel of text or of another length does not spoil the guess for the others
            if error.code not in ("E328", "E314"):
                raise
            return None
    return np.concatenate(out)[:MAX_ROWS] if out else None


def _common(data: dict[str, Array]) -> int:
    lengths = [len(v) for v in data.values()]
    return max(set(lengths), key=lengths.count)


def _time(channels: list[Channel], data: dict[str, Array], reasons: list[str]) -> tuple[str | None, str]:
    """Return the channel that looks like time and its unit."""
    scores: dict[str, float] = {}
    for place, channel in enumerate(channels):
        values = data.get(channel.name)
        if values is None or not np.isfinite(values).all():
            continue
        steps = np.diff(values)
        forward = float(np.mean(steps >= 0))
        if forward < 0.98 or values[-1] <= values[0]:
            continue
        even = float(np.median(np.abs(steps - np.median(steps))) / (np.median(steps) or np.inf))
        scores[channel.name] = (
            forward
            + (1.0 if _TIME.search(channel.name.replace("_", " ")) else 0.0)
            + (0.5 if even < 0.2 else 0.0)
            + (0.2 if place == 0 else 0.0)
        )
    if not scores:
        reasons.append("no channel runs forward like time: give its rate (rate_hz) instead")
        return None, "s"
    best = max(scores, key=lambda n: scores[n])
    channel = next(c for c in channels if c.name == best)
    steps = np.diff(data[best])
    step = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    unit = channel.unit if channel.unit and unit_of(channel.unit)[0] == "time" else ""
    why = "its name" if unit else f"its usual step of {step:g}"
    unit = unit or ("s" if step < 0.5 else "ms" if step < 500 else "us" if step < 5e5 else "ns")
    repeated = int((steps == 0).sum())
    reasons.append(
        f"time_s: '{best}' runs forward in {100 * np.mean(steps >= 0):.1f} % of the steps; unit {unit} from {why}"
    )
    if repeated:
        reasons.append(f"time repeats in {100 * repeated / len(steps):.0f} % of the steps: the last of a tick is kept")
    return best, unit


def _antagonists(usable: list[Channel], data: dict[str, Array], reasons: list[str]) -> list[Channel]:
    """Return two channels that look like the tensions of an antagonistic pair of tendons."""
    for i, a in enumerate(usable):
        for b in usable[i + 1 :]:
            x, y = data[a.name], data[b.name]
            if not (np.isfinite(x).all() and np.isfinite(y).all()):
                continue
            top = max(x.max(), y.max())
            positive = min(x.min(), y.min()) > -0.05 * top and min(x[0], y[0]) > 0.1 * top
            if positive and abs(x[0] - y[0]) < 0.1 * top and np.corrcoef(x, y)[0, 1] < -0.7:
                reasons.append(
                    f"tension_in_n: '{a.name}' minus '{b.name}', an antagonistic pair: "
                    f"both positive, equal at the start, and moving against "
                    f"each other (correlation {np.corrcoef(x, y)[0, 1]:.2f})"
                )
                return [a, b]
    return []


def _follows(drive: Array, others: list[Channel], data: dict[str, Array], reasons: list[str]) -> Channel | None:
    """Return the channel that follows the drive most."""
    scores = {
        c.name: abs(float(np.corrcoef(drive, data[c.name])[0, 1])) for c in others if np.isfinite(data[c.name]).all()
    }
    if not scores:
        return None
    best = max(scores, key=lambda n: scores[n])
    ranking = ", ".join(f"{n} {scores[n]:.2f}" for n in sorted(scores, key=lambda n: -scores[n])[:4])
    reasons.append(f"tension_out_n: '{best}' follows it most (correlations: {ranking}); check what it measures")
    return next(c for c in others if c.name == best)


def _pair(usable: list[Channel], data: dict[str, Array], reasons: list[str]) -> tuple[Channel | None, Channel | None]:
    """Return the likely input and output: by name, else the pair that moves together most."""
    if len(usable) < 2:
        reasons.append("fewer than two channels move: no tensions proposed")
        return None, None
    by_name = {}
    for role, pattern in (("tension_in_n", _INPUT), ("tension_out_n", _OUTPUT)):
        named = [c for c in usable if pattern.search(c.name.replace("_", " "))]
        named.sort(key=lambda c: not (_TENSION.search(c.name) or (c.unit and unit_of(c.unit)[0] == "force")))
        if named:
            by_name[role] = named[0]
    if len(by_name) == 2 and by_name["tension_in_n"] != by_name["tension_out_n"]:
        pair = by_name["tension_in_n"], by_name["tension_out_n"]
        reasons.append(f"tension_in_n: '{pair[0].name}' and tension_out_n: '{pair[1].name}', by their names")
        return pair
    table = np.vstack([np.nan_to_num(data[c.name]) for c in usable])
    with np.errstate(invalid="ignore", divide="ignore"):
        together = np.abs(np.nan_to_num(np.corrcoef(table)))
    np.fill_diagonal(together, 0)
    # copies of one channel tell nothing
    together[together > 0.9995] = 0
    for i, channel in enumerate(usable):
        if _TENSION.search(channel.name) or (channel.unit and unit_of(channel.unit)[0] == "force"):
            together[i] *= 1.5
            together[:, i] *= 1.5
    i, j = sorted(int(k) for k in np.unravel_index(int(np.argmax(together)), together.shape))
    pair = usable[i], usable[j]
    smooth = [float(np.std(np.diff(data[c.name])) / (np.std(data[c.name]) or 1)) for c in pair]
    reasons.append(
        f"tension_in_n: '{pair[0].name}' and tension_out_n: '{pair[1].name}' move together most "
        f"(correlation {np.corrcoef(table[i], table[j])[0, 1]:.2f}, roughness {smooth[0]:.2g}, {smooth[1]:.2g}); "
        "which is the input is a guess"
    )
    return pair


def _toml(
    chosen: Format,
    channels: list[Channel],
    time: str | None,
    unit: str,
    first: Channel | None,
    second: Channel | None,
    usable: list[Channel],
    against: list[Channel],
) -> str:
    lines = [
        "# Proposed by sstl import --guess: check every line marked (?).",
        f"format = {json.dumps(chosen.ID)}",
        "",
        "[columns]",
    ]
    place = {c.name: i + 1 for i, c in enumerate(channels)}
    lines.append(
        f"time_s = {{ column = {json.dumps(time)}, unit = {json.dumps(unit)} }}"
        if time
        else "time_s = { rate_hz = 1000 }  # (?)"
    )
    for role, channel in (("tension_in_n", first), ("tension_out_n", second)):
        if channel is None:
            lines.append(f'# {role} = {{ column = "...", unit = "N" }}  # (?)')
            continue
        if against and role == "tension_in_n":
            names = ", ".join(json.dumps(c.name) for c in against)
            lines.append(
                f'{role} = {{ minus = [{names}], unit = "N" }}  # (?) swap them if pulling should raise the input'
            )
            continue
        dimension = unit_of(channel.unit)[0] if channel.unit else ""
        given = channel.unit if dimension == "force" else "N"
        extra = ', as = "N"' if dimension in ("angle", "length") and role == "tension_out_n" else ""
        given = channel.unit if extra else given
        note = "" if dimension == "force" else f"  # (?) channel {place[channel.name]}, unit not stated"
        lines.append(f"{role} = {{ column = {json.dumps(channel.name)}, unit = {json.dumps(given)}{extra} }}{note}")
    position = next((c for c in usable if _POSITION.search(c.name) and c not in (first, second)), None)
    if position is not None:
        known = position.unit if position.unit and unit_of(position.unit)[0] == "length" else "mm"
        lines.append(f"position_in_mm = {{ column = {json.dumps(position.name)}, unit = {json.dumps(known)} }}  # (?)")
    lines += ["", "[constants]", 'system = "act"  # (?) act: single pass, sstl: double pass', ""]
    return "\n".join(lines)


def loop(x: Array, y: Array, columns: int = 56, rows: int = 16) -> list[str]:
    """Return a plot of ``y`` over ``x`` in Braille dots, as lines of text."""
    good = np.isfinite(x) & np.isfinite(y)
    x, y = x[good], y[good]
    if not len(x) or np.ptp(x) == 0 or np.ptp(y) == 0:
        return []
    across = np.minimum((x - x.min()) / np.ptp(x) * (2 * columns), 2 * columns - 1).astype(int)
    up = np.minimum((y.max() - y) / np.ptp(y) * (4 * rows), 4 * rows - 1).astype(int)
    dots = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])
    cells = np.zeros((rows, columns), int)
    np.bitwise_or.at(cells, (up // 4, across // 2), dots[up % 4, across % 2])
    lines = ["".join(chr(0x2800 + c) for c in row) for row in cells]
    return [*lines, f"x {x.min():.4g} to {x.max():.4g}, y {y.min():.4g} to {y.max():.4g}"]
