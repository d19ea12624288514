"""Which channels are the input and the output tension: names first, the motion only where names say nothing."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sstl_cli.importers.guess_names import RUN_BEHIND, RUN_IN_FRONT, Said
from sstl_cli.importers.guess_words import QUANTITY_OF, RMS, SIDE_OF, TREATED, UNIT_WORDS, words

Array = NDArray[np.float64]
# of the largest correlation, how much tells as little, and how much more the side that pulls moves
ALIKE, LARGER = 0.9, 1.1
# rows that show a motion, and the area of a loop, in that of the box around it, that noise does not leave
_ENOUGH, _TURNED = 50, 0.02
# channels that a question names
_SHOWN = 6
# "F/T Sequence", "Force sample": the last word says what it is of these
_NUMBERING = {"sequence", "seq", "index", "idx", "counter", "sample", "samples"}
# of what a sensor said, beside what was wanted
_MEASURED = words("meas measured gemessen ist mesure mesuree medida medido misurata misurato")
SIDES = {"tension_in_n": "in", "tension_out_n": "out"}
OTHER = {"in": "tension_out_n", "out": "tension_in_n"}


@dataclass(frozen=True)
class Roles:
    """The channels proposed for input and output (two for a difference), a question for each, and the reasons."""

    first: tuple[Said, ...] = ()
    second: tuple[Said, ...] = ()
    ask_first: str = ""
    ask_second: str = ""
    reasons: tuple[str, ...] = ()

    def of(self, target: str) -> tuple[tuple[Said, ...], str]:
        """Return channels and question of ``tension_in_n`` or ``tension_out_n``."""
        return (self.first, self.ask_first) if target == "tension_in_n" else (self.second, self.ask_second)


def guess_roles(names: list[Said], data: dict[str, Array]) -> Roles:
    """Return the likely tensions of a recording.

    Parameters
    ----------
    names : list of Said
        Channels that move, without the clock.
    data : dict
        First samples of each channel, shape (n,).
    """
    tensions = measured(names)
    roles = _of_tensions(tensions, names, data)
    return replace(roles, ask_first=doubted(roles.first, roles.ask_first), ask_second=doubted(roles.second, roles.ask_second))


def measured(names: list[Said]) -> list[Said]:
    """Return the tensions without those that were not measured by their names where one beside them was, nor what only numbers readings of forces."""
    tensions = [s for s in names if s.tension and not (s.words[-1:] and s.words[-1] in _NUMBERING and not s.unit)]
    tensions = [s for s in tensions if not any(_measured_of(s, m) for m in tensions)]
    sure = [s for s in tensions if not s.unmeasured]
    return [s for s in tensions if not s.unmeasured or not any(not s.side or m.side in (s.side, "") for m in sure)]


def _measured_of(one: Said, other: Said) -> bool:
    """Return whether another channel is called as one is, and measured (``T_in_N`` beside ``T_in_meas_N``)."""
    more = set(other.words) - set(one.words)
    return one.side == other.side != "" and set(one.words) < set(other.words) and more <= _MEASURED


def doubted(found: tuple[Said, ...], question: str) -> str:
    """Return the question of a side with another one where a name says that its channel was not measured, or a multiple."""
    told = {w for s in found if (w := s.unmeasured or min(RMS.intersection(s.words), default=""))}
    doubt = f"'{min(told)}' in its name: was this measured?" if told else ""
    times = {m for s in found if (m := s.multiple) and m not in told}
    multiple = (
        f"'{min(times)}' in its name: are these readings that multiple of the force (then give scale), or the force itself?"
        if times
        else ""
    )
    return "; ".join(filter(None, (question, doubt, multiple)))


def _of_tensions(tensions: list[Said], names: list[Said], data: dict[str, Array]) -> Roles:
    """Return which of the tensions are the input and the output; where none is named so, which other channels may be."""
    # where two are forces by their units, a tension in V is that of the mains or of a motor
    forces = [s for s in tensions if s.dimension == "force"]
    tensions = forces if len(forces) > 1 else tensions
    sided = {side: [s for s in tensions if s.side == side] for side in ("in", "out")}
    plain = [s for s in tensions if not s.side]
    if len(sided["in"]) == 1 and len(sided["out"]) == 1:
        a, b = sided["in"][0], sided["out"][0]
        ask = _returning(plain)
        against = _against(a, b, data)
        ask = "; ".join(filter(None, (against, ask)))
        return Roles((a,), (b,), against, ask, reasons=(f"tension_in_n: '{a.name}' and tension_out_n: '{b.name}', by their names",))
    if sided["in"] and sided["out"]:
        return _several(sided["in"], sided["out"])
    for side in ("in", "out"):
        if len(sided[side]) == 1 and len(plain) == 1:
            return _by_exclusion(sided[side][0], plain[0], side)
        if sided[side] and not plain:
            return _only(sided[side], side)
        if sided[side] and plain:
            found = _several(sided["in"] or plain, sided["out"] or plain)
            ask = "; ".join(filter(None, (_other_side(sided[side], plain[0], side), found.of(OTHER[side])[1])))
            return replace(found, ask_second=ask) if side == "in" else replace(found, ask_first=ask)
    if len(plain) == 1:
        if other := _beside(names):
            return _named_side(plain[0], other)
        # beside the command of a motion it likely is what comes out of it, but a rig may record its input alone
        commanded = any(s.reference and s.quantity != "force" and s.dimension != "force" for s in names)
        side = "out" if commanded or not any(s.side == "out" for s in names) else "in"
        return _only(plain, side, sure=False)
    if len(plain) > 1:
        return _antagonists(plain, names, data) or _unsided(plain, data)
    return _unnamed(names, data)


def _against(a: Said, b: Said, data: dict[str, Array]) -> str:
    """Return the question whether two tensions are swapped whose motion says the opposite of their names: friction takes and delays, it gives nothing."""
    x, y = data[a.name], data[b.name]
    # in other units, or where one is negative, it is not known which moves more
    if len(x) != len(y) or len(x) < _ENOUGH or a.unit != b.unit or (np.nanmedian(x) < 0) != (np.nanmedian(y) < 0):
        return ""
    good = np.isfinite(x) & np.isfinite(y)
    x, y = np.abs(x[good]), np.abs(y[good])
    spans = [float(np.subtract(*np.percentile(v, (98, 2)))) if len(v) else 0.0 for v in (x, y)]
    if min(spans) <= 0 or spans[1] < LARGER * spans[0]:
        return ""
    # twice the area of the loops, closed at the end; an output that comes later turns them one way, one that comes first the other
    x, y = (v - v[0] for v in (x, y))
    turned = float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / (spans[0] * spans[1])
    return f"'{b.name}' moves more than '{a.name}' and comes first, as an input does: are the names swapped?" if turned < -_TURNED else ""


def _returning(plain: list[Said]) -> str:
    """Return the question whether a tension whose name says both sides (``T_prox_out``, ``Proximal return``) is the output, as of a double pass."""
    both = [s for s in plain if {SIDE_OF.get(w) for w in s.words} >= {"in", "out"}]
    return f"or {', '.join(repr(s.name) for s in both)}, which is the output of sstl, where the tendon comes back?" if both else ""


def _beside(names: list[Said]) -> Said | None:
    """Return the channel that is named by its side alone, without a quantity and a unit; None where none or several are."""
    found = [s for s in names if s.side and not s.quantity and not s.unit and not s.strange and not s.reference]
    return found[0] if len(found) == 1 else None


def _named_side(tension: Said, other: Said) -> Roles:
    """Return a tension of no side beside a channel whose name says its side and nothing else: both are asked."""
    what = f"'{other.name}' is the {other.side}put by its name"
    reasons = (f"{what}, '{tension.name}' is the only channel named as a tension",)
    mine, its = f"{what}: is this the {'input' if other.side == 'out' else 'output'}?", "is this a tension?"
    return Roles((tension,), (other,), mine, its, reasons) if other.side == "out" else Roles((other,), (tension,), its, mine, reasons)


def _other_side(known: list[Said], other: Said, side: str) -> str:
    """Return the question whether a tension of no side is what those of a side are not."""
    if side == "out" and re.search(r"\sin\s", other.name):
        # "Force in N" beside "Force out N": the unit's word or the side's, it is the input
        return ""
    shown = ", ".join(repr(s.name) for s in known)
    return f"{shown} {'is' if len(known) == 1 else 'are'} the other side: is this the {'output' if side == 'in' else 'input'}?"


def _by_exclusion(known: Said, other: Said, side: str) -> Roles:
    question = _other_side([known], other, side)
    reasons = (f"'{known.name}' is the {side}put by its name, '{other.name}' is the only other tension",)
    if side == "in":
        return Roles((known,), (other,), "", question, reasons)
    return Roles((other,), (known,), question, "", reasons)


def _several(first: list[Said], second: list[Said]) -> Roles:
    asks = [_which(many) for many in (first, second)]
    reasons = (f"{len(first)} channels look like the input and {len(second)} like the output",)
    return Roles((first[0],), (second[0],), asks[0], asks[1], reasons)


def _which(many: list[Said]) -> str:
    """Return the question which of several channels of a side is meant: of one sensor which was measured, else which tendon."""
    others = ", ".join(repr(s.name) for s in many[1:5])
    if not others:
        return ""
    if all(RUN_IN_FRONT.match(s.name) or RUN_BEHIND.fullmatch(s.name) for s in many):
        return f"or {others}? They are runs side by side: write each to a file of its own"
    one_sensor = any(w in TREATED for s in many for w in s.words)
    return f"or {others}? {'name the one that was measured' if one_sensor else 'give each tendon a mapping of its own'}"


def _only(found: list[Said], side: str, sure: bool = True) -> Roles:
    one = (found[0],)
    ask = f"or {', '.join(repr(s.name) for s in found[1:5])}?" if found[1:] else ""
    ask = ask or ("" if sure else "is this the output, or the input?")
    what, other = ("output", "input") if side == "out" else ("input", "output")
    said = f"is the {what}; no other channel is named as a tension" if sure else "is the only channel named as a tension, of whichever side"
    reasons: tuple[str, ...] = (f"'{found[0].name}' {said}",)
    missing = f"only one tension here: where is the {other}?"
    if found[1:]:
        shown = ", ".join(repr(s.name) for s in found[:5])
        missing = f"{shown} all say {what}: which of them, or which other channel, is the {other}?"
    return Roles(one, (), ask, missing, reasons) if side == "in" else Roles((), one, missing, ask, reasons)


def _unsided(found: list[Said], data: dict[str, Array]) -> Roles:
    """Return two tensions whose names say no side: the one that leads and moves more is proposed as the input."""
    a, b = found[:2]
    x, y = data[a.name], data[b.name]
    leads = _lead(x, y) if len(x) == len(y) else 0.0
    if leads < 0 or (leads == 0 and np.ptp(y) > np.ptp(x)):
        a, b = b, a
    more = f" (of {', '.join(repr(s.name) for s in found)})" if len(found) > 2 else ""
    question = "the names do not say which is the input: this one leads or moves more"
    reasons = (f"'{a.name}' and '{b.name}' are tensions{more}; which is the input is a guess from the motion",)
    return Roles((a,), (b,), question + more, "is this the output?", reasons)


def _lead(x: Array, y: Array) -> float:
    """Return by how many samples ``x`` comes before ``y`` (negative: after), within a hundredth of the record."""
    good = np.isfinite(x) & np.isfinite(y)
    x, y = x[good] - np.mean(x[good]), y[good] - np.mean(y[good])
    reach = max(1, len(x) // 100)
    scores = [float(np.dot(x[reach:-reach], y[reach + k : len(y) - reach + k])) for k in range(-reach, reach + 1)]
    return float(int(np.argmax(scores)) - reach) if len(x) > 2 * reach + 2 else 0.0


def _antagonists(plain: list[Said], names: list[Said], data: dict[str, Array]) -> Roles | None:
    """Return the difference of two tensions that pull against each other, and what follows it."""
    for i, a in enumerate(plain):
        for b in plain[i + 1 :]:
            x, y = data[a.name], data[b.name]
            if len(x) != len(y) or not (np.isfinite(x).all() and np.isfinite(y).all()):
                continue
            top = max(x.max(), y.max())
            positive = min(x.min(), y.min()) > -0.05 * top and min(x[0], y[0]) > 0.1 * top
            together = float(np.corrcoef(x, y)[0, 1])
            if positive and abs(x[0] - y[0]) < 0.1 * top and together < -0.7:
                reason = (
                    f"tension_in_n: '{a.name}' minus '{b.name}', an antagonistic pair: both positive, equal at the "
                    f"start, and moving against each other (correlation {together:.2f})"
                )
                others = [s for s in names if s not in (a, b) and not s.reference]
                second, why = _follows(x - y, others, data)
                return Roles((a, b), second, "swap them if pulling should raise the input", "what is this?", (reason, *why))
    return None


def _follows(drive: Array, others: list[Said], data: dict[str, Array]) -> tuple[tuple[Said, ...], tuple[str, ...]]:
    """Return the channel that follows the drive most."""
    fit = [s for s in others if len(data[s.name]) == len(drive) and np.isfinite(data[s.name]).all()]
    scores = {s.name: abs(float(np.corrcoef(drive, data[s.name])[0, 1])) for s in fit}
    if not scores:
        return (), ()
    best = max(fit, key=lambda s: scores[s.name])
    ranking = ", ".join(f"{n} {scores[n]:.2f}" for n in sorted(scores, key=lambda n: -scores[n])[:4])
    return (best,), (f"tension_out_n: '{best.name}' follows it most (correlations: {ranking}); check what it measures",)


def _unnamed(names: list[Said], data: dict[str, Array]) -> Roles:
    """Return channels whose names say no force: those named input and output, an antagonistic pair, the most alike."""
    usable = [s for s in names if s.quantity in ("", "pressure", "position", "angle") and not s.reference]
    volts = [s for s in names if s.dimension == "voltage" and not s.reference and not _of_else(s)]
    numbered = [s for s in usable if s.words[:1] in (("t",), ("f",)) and s.words[1:] and s.words[1].isdigit() and not s.quantity]
    # what a card reads of two load cells, or T1 and T2, whatever else moves beside them
    usable = next((few for few in (volts, numbered) if len(few) > 1), usable)
    # beside two that may be tensions, what is named as a position is none
    bare = [s for s in usable if s.quantity not in ("position", "angle") and s.dimension not in ("length", "angle")]
    usable = bare if len(bare) > 1 else usable
    by_side = [[s for s in usable if s.side == side] for side in ("in", "out")]
    if len(by_side[0]) == 1 and len(by_side[1]) == 1:
        a, b = by_side[0][0], by_side[1][0]
        reasons = (f"'{a.name}' and '{b.name}' are input and output by their names, which do not say what of",)
        return Roles((a,), (b,), "is this a tension?", "is this a tension?", reasons)
    common = [s for s in usable if len(data[s.name]) == _common(usable, data)]
    pair = _antagonists([s for s in common if not s.quantity], common, data)
    if pair is not None:
        return pair
    if len(common) < 2:
        few = (
            "fewer than two channels move"
            if len(names) < 2
            else f"of {len(names)} channels that move none is named as a tension, nor two as anything that may be"
        )
        shown = f"which channel: {', '.join(repr(s.name) for s in names[:_SHOWN])}?" if names else "which channel?"
        odd = [s for s in names if s.quantity == "force" and s.unit and s.dimension != "force"]
        shown += "".join(f" '{s.name}' is called a force, and has the unit {s.unit} in the file" for s in odd[:1])
        return Roles(ask_first=shown, ask_second=shown, reasons=(few,))
    table = np.vstack([np.nan_to_num(data[s.name]) for s in common])
    with np.errstate(invalid="ignore", divide="ignore"):
        together = np.abs(np.nan_to_num(np.corrcoef(table)))
    np.fill_diagonal(together, 0)
    # copies of one channel tell nothing
    together[together > 0.9995] = 0
    i, j = sorted(int(k) for k in np.unravel_index(int(np.argmax(together)), together.shape))
    alike = [k for k in range(len(common)) if max(together[i, k], together[j, k]) >= ALIKE * together[i, j] and k not in (i, j)]
    if alike and not any(s.words and (s.side or s.quantity or s.unit) for s in names) and together[i, j] > 0:
        shown = ", ".join(repr(common[k].name) for k in sorted((i, j, *alike)))
        reason = f"{shown} move alike, and no name says what any of them is: no channel is proposed"
        return Roles(ask_first="which channel?", ask_second="which channel?", reasons=(reason,))
    one_unit = (common[i].quantity, common[i].unit) == (common[j].quantity, common[j].unit)
    moved = [float(np.ptp(table[k])) for k in (i, j)]
    by_size = ""
    if one_unit and max(moved) >= LARGER * min(moved):
        i, j = (i, j) if moved[0] > moved[1] else (j, i)
        by_size = f" ('{common[i].name}' moves more, as the side that pulls does against friction)"
    reason = (
        f"'{common[i].name}' and '{common[j].name}' move together most (correlation "
        f"{np.corrcoef(table[i], table[j])[0, 1]:.2f}); which is the input{by_size}, and whether they are tensions, is a guess"
    )
    return Roles((common[i],), (common[j],), "is this the input tension?", "is this the output?", (reason,))


def _of_else(one: Said) -> bool:
    """Return whether a channel's name says that it measures something else, such as a temperature read as a voltage."""
    return any(QUANTITY_OF.get(w) == "other" and UNIT_WORDS.get(w) != "V" and w != "voltage" for w in one.words)


def _common(names: list[Said], data: dict[str, Array]) -> int:
    lengths = [len(data[s.name]) for s in names]
    return max(set(lengths), key=lengths.count) if lengths else 0
