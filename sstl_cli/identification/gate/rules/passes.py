"""A single pass labelled as a double one, or the other way round: friction of the loop is about twice that of actuation."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from sstl_cli.identification.gate.evidence import Evidence
from sstl_cli.identification.gate.remark import Remark, Severity, names
from sstl_cli.identification.gate.rules.two_rigs import second_pass, second_rig
from sstl_cli.identification.gate.slopes import AGREED_APART

RULE, RANK = "passes", 50
# friction per pass of a run over that of the other runs of its bend: 2 or 1/2 where the label is wrong, up to 1.3 in a
# sensing loop with a pulley
TWICE, MOST = 1.7, 5.6
# factor within which friction that presliding hides is known
NEAR_PASS = 1.25
# on a nearly straight tube ends and pulleys decide
LEAST = 0.12
# logarithm of a gain that sensors may have
GAIN, NO_GAIN = 0.45, 0.1
# how far (logarithm) a run's gain may be from that of the widest movement
APART = 0.2
# n theta that divides single from double passes where nothing else does: theta is 0.3 to 0.7 in published rigs
BETWEEN, SINGLE = 0.8, 0.35
# n theta that no single pass reaches: mu of 0.2 over a full turn, or 0.4 over a half one, is 1.26; up to there size alone tells nothing
DOUBLE = 1.26
# part of the input's span by which the same range may differ, and noises that an output must go over to be compared
SAME_RANGE, SHOWS = 0.1, 40.0
# part of what the bends of both systems differ by as labelled that may be left of it in the order of their friction, which shuffled labels of bends keep
ORDERED = 0.2
# part of the log's widest movement over which a run must go for the size of its friction to count
WIDE = 0.5


def look(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield runs whose slopes are those of the other system."""
    # slopes that need a gain as well tell little of friction
    sloped = [e for e in log if e.slopes.known and e.slopes.friction > 0.0 and abs(math.log(e.slopes.gain)) < GAIN]
    sloped = _one_gain(sloped)
    both = {e.run_id for e in sloped}
    pulls = {e.run_id for e in log if not e.slopes.known and e.wrap > 0.0} if _unscaled(sloped) else set()
    known = [e for e in log if e.run_id in both | pulls]
    bends: dict[object, list[Evidence]] = {}
    for e in known:
        bends.setdefault((e.config_id, e.location), []).append(e)
    paired = len({e.system for e in known}) == 2
    pairs = [b for b in bends.values() if paired and len(b) > 1 and b[0].config_id is not None]
    wrong = [] if second_rig(log)[0] else [e for bend in pairs for e in _wrong(bend, known)]
    wrong = [] if _bends_shuffled(pairs) else _everywhere(wrong, log)
    yield from _told(wrong, "failure", "beside the other runs of the same bend", _shuffled(wrong, pairs), known)
    if paired and not wrong and not second_rig(log)[0]:
        about = list(_about(log, known))
        yield from about or _passed_on(log)
    if not pairs and known and not second_rig(log)[0]:
        found = [kinds for bend in bends.values() if bend[0].config_id is not None and (kinds := _two_kinds(bend, log)) is not None]
        mixed = [double if double[0].system == "act" else single for single, double in found] if _doubled(found) else []
        one_bend = "beside other runs of the same bend and label"
        yield from _told([e for hit in mixed for e in hit], "failure" if len(mixed) > 1 else "remark", one_bend)
        if not found:
            yield from _alone(sloped, log)


def _about(log: Sequence[Evidence], known: list[Evidence]) -> Iterator[Remark]:
    """Yield the one run whose friction, hidden by presliding, is that of another number of passes beside runs of both labels that tell theirs."""
    sure = {e.run_id for e in known}
    hit = []
    for e in log:
        bend = [o for o in known if e.config_id is not None and (o.config_id, o.location, o.tendon) == (e.config_id, e.location, e.tendon)]
        if e.run_id in sure or not e.wrap_about > LEAST or {o.system for o in bend} != {"act", "sstl"}:
            continue
        own, other = ([o.wrap for o in bend if (o.system == e.system) == same] for same in (True, False))
        # nearer to the other label than any run of its own, and by a pass from these
        away = max(abs(math.log(e.wrap_about / v)) for v in other) < math.log(NEAR_PASS) and min(
            abs(math.log(e.wrap_about / v)) for v in own
        ) > math.log(TWICE)
        # presliding of one movement may look like friction of another one
        if away and not _allowed(e, bend):
            hit.append(e)
    if len(hit) == 1:
        yield from _told(hit, "remark", "beside the other runs of the same bend")


def _passed_on(log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield the one run whose output goes as far as in the runs of the other label, and no other of its own does, where all inputs of the bend go the same way.

    Whatever the law, friction passes on as much of the same range of tension, so that no lines are asked.
    """
    bends: dict[object, list[Evidence]] = {}
    for e in log:
        if e.tendon_like and e.config_id is not None:
            bends.setdefault((e.config_id, e.location, e.tendon), []).append(e)
    hit = [e for bend in bends.values() if len({e.system for e in bend}) == 2 for e in _passes_otherwise(bend)]
    if len(hit) == 1:
        e = hit[0]
        right, like = ("sstl", "a double pass") if e.system == "act" else ("act", "a single pass")
        yield Remark(
            (e.run_id,), RULE, "remark", e.ranges[1].span, "N",
            f"{names([e.run_id])}: labelled {e.system}, but its output goes over {e.ranges[1].span:.3g} N, as in the {right} runs of the same bend and range of input and not as in "
            f"the other {e.system} runs, which looks like {like}; the label of its system is probably wrong",
            f'[constants] system = "{right}" (for this file)',
        )  # fmt: skip


def _passes_otherwise(bend: list[Evidence]) -> list[Evidence]:
    """Return the runs of a bend whose output goes as far as in those of the other label with the same range of the input, and not as in those of their own."""
    low, high, goes = (np.array(v) for v in zip(*((e.ranges[0].low, e.ranges[0].high, e.ranges[1].span) for e in bend), strict=True))
    double = np.array([e.system == "sstl" for e in bend])
    found = []
    for k, e in enumerate(bend):
        near = np.abs(low - low[k]) + np.abs(high - high[k]) < SAME_RANGE * e.ranges[0].span
        near[k] = False
        own, other = near & (double == double[k]), near & (double != double[k])
        if not own.any() or not other.any() or goes[k] < SHOWS * e.sensors[1].noise_n or goes.min() <= 0.0:
            continue
        # the loop passes on less
        way = -1.0 if double[k] else 1.0
        like, unlike = np.log(goes[other] / goes[k]), way * np.log(goes[own] / goes[k])
        if float(np.max(np.abs(like))) < math.log(NEAR_PASS) and float(np.min(unlike)) > math.log(TWICE):
            found.append(e)
    return found


def _everywhere(wrong: list[Evidence], log: Sequence[Evidence]) -> list[Evidence]:
    """Return the wrong runs, and where both systems are exchanged in every bend that tells, those of all other bends as well.

    A bend whose slopes do not show tells by what it passes on: the loop passes on less than its first half.
    """
    if len({e.system for e in wrong}) < 2:
        return wrong
    rest: dict[object, list[Evidence]] = {}
    for e in log:
        if e.usable and e.config_id is not None:
            rest.setdefault((e.config_id, e.location, e.tendon), []).append(e)
    every = [b for b in rest.values() if {e.system for e in b} == {"act", "sstl"}]
    passed = [
        {s: max(e.ranges[1].span / max(e.ranges[0].span, 1e-300) for e in b if e.system == s) for s in ("act", "sstl")} for b in every
    ]
    return [e for b in every for e in b] if all(p["act"] < p["sstl"] for p in passed) else wrong


def _one_gain(sloped: list[Evidence]) -> list[Evidence]:
    """Return the runs whose gain is that of the widest movement: the sensors are the same, so other slopes are those of presliding."""
    if not sloped:
        return []
    # where several are as wide, presliding has spoilt that least whose gain is nearest none
    widest = min((math.log(e.slopes.gain) for e in _wide(sloped, sloped)), key=abs)
    sound = [e for e in sloped if abs(math.log(e.slopes.gain) - widest) < APART]
    # friction puts the pull below the sensors' gain and the release above it
    return [e for e in sound if math.log(e.slopes.gamma_p) < widest < math.log(e.slopes.gamma_r)]


def _unscaled(sloped: list[Evidence]) -> bool:
    """Whether the runs that tell say that sensors have no gain: then a pull alone tells friction."""
    return bool(sloped) and abs(float(np.median([math.log(e.slopes.gain) for e in sloped]))) < NO_GAIN


def _wrong(bend: list[Evidence], known: list[Evidence]) -> list[Evidence]:
    """Return the runs of one bend whose friction per pass is about twice, or half, that of the others."""
    per = {e.run_id: e.wrap / e.passes for e in bend}
    if max(e.wrap for e in bend) < LEAST:
        return []
    doubtful = []
    for e in bend:
        others = [per[o.run_id] for o in bend if o is not e and o.tendon in (e.tendon, None)]
        if not others:
            continue
        # friction of one movement is not that of another one: where the same one was recorded it must say so as well
        same = [per[o.run_id] for o in bend if o is not e and o.tendon in (e.tendon, None) and o.trajectory == e.trajectory is not None]
        odd = all(_another_pass(e, per[e.run_id] / float(np.median(v))) for v in (others, same) if v)
        if odd and not _allowed(e, [o for o in bend if o is not e and o.tendon in (e.tendon, None)]):
            doubtful.append(e)
    if len({e.system for e in doubtful}) < 2:
        return doubtful
    ratio = _middle(doubtful, "sstl") / _middle(doubtful, "act")
    if ratio < 1.0 / TWICE:
        return doubtful
    # both look alike: the one that differs from its kind elsewhere is wrong, else the size decides
    elsewhere = [e for e in known if e.config_id != bend[0].config_id]
    single, double = _middle(elsewhere, "act"), _middle(elsewhere, "sstl")
    between = float(np.sqrt(single * double)) if single < double / TWICE else BETWEEN
    size = float(np.median([e.wrap for e in doubtful]))
    return [e for e in doubtful if e.system == ("sstl" if size < between else "act")]


def _another_pass(e: Evidence, ratio: float) -> bool:
    """Whether friction per pass, over that of other runs, is that of a run of the other system."""
    return TWICE < ratio < MOST if e.system == "act" else 1.0 / MOST < ratio < 1.0 / TWICE


def _bends_shuffled(pairs: list[list[Evidence]]) -> bool:
    """Whether both systems hold the same bends, in another order: friction of the loops is then that of the other labels of bends, and no system has the label of the other one.

    Of runs in order of their friction the one system rubs by one factor more than the other, and not so of bends by their labels.
    """
    bends = [{s: [e.wrap for e in bend if e.system == s] for s in ("act", "sstl")} for bend in pairs]
    bends = [b for b in bends if b["act"] and b["sstl"]]
    single, double = (np.sort(np.concatenate([b[s] for b in bends])) if bends else np.empty(0) for s in ("act", "sstl"))
    if len(bends) < 2 or len(single) != len(double):
        single, double = (np.sort([float(np.median(b[s])) for b in bends]) for s in ("act", "sstl"))
    if len(single) < 2:
        return False
    ordered, labelled = np.log(double / single), [math.log(np.median(b["sstl"]) / np.median(b["act"])) for b in bends]
    # two passes rub as much as twice one, with a pulley up to 1.7 times more or less
    twice = abs(float(np.median(ordered)) - math.log(2.0)) < math.log(TWICE)
    apart = float(np.ptp(labelled))
    return twice and apart > math.log(TWICE) and float(np.ptp(ordered)) < max(math.log(NEAR_PASS), ORDERED * apart)


def _allowed(e: Evidence, others: list[Evidence]) -> bool:
    """Whether some sound law of friction makes a run agree with the others of its bend, as labelled: lines of presliding tell anything."""
    mine, theirs = (v / e.passes for v in e.wraps), [[v / o.passes for v in o.wraps] for o in others]
    low, high = mine
    return low < NEAR_PASS * float(np.median([v[1] for v in theirs])) and NEAR_PASS * high > float(np.median([v[0] for v in theirs]))


def _middle(runs: list[Evidence], system: str) -> float:
    found = [e.wrap for e in runs if e.system == system]
    return float(np.median(found)) if found else float("nan")


Kinds = tuple[list[Evidence], list[Evidence]]


def _doubled(found: list[Kinds]) -> bool:
    """Whether the two kinds of every bend differ by a second pass: twice the friction, and that of a pulley, which is the same in all bends.

    Of two rigs the one rubs more by a factor of its own, or by more the more the bend rubs.
    """
    if not found:
        return False
    low, high = (np.array([float(np.median([e.wrap for e in kinds[i]])) for kinds in found]) for i in (0, 1))
    return second_pass(low, high, np.array([2.0 * max(_error(e) for kind in kinds for e in kind) for kinds in found]))


def _error(e: Evidence) -> float:
    """Return the relative error of a run's friction; that of a pull alone is as large as what a pull and a release may differ by."""
    return e.slopes.friction_se / e.slopes.friction if e.slopes.known else 0.5 * AGREED_APART


def _two_kinds(bend: list[Evidence], log: Sequence[Evidence]) -> Kinds | None:
    """Return the runs of a bend with one label that rub as one pass and as two, None where they are of one kind."""
    if len(bend) < 2:
        return None
    wide = sorted(_wide(bend, log), key=lambda e: e.wrap)
    logs = np.log([e.wrap for e in wide])
    if len(wide) < 2 or len({(e.system, e.tendon) for e in wide}) > 1 or wide[-1].wrap < LEAST:
        return None
    at = 1 + int(np.argmax(np.diff(logs)))
    spread = max(float(np.ptp(logs[:at])), float(np.ptp(logs[at:])))
    apart = float(np.mean(logs[at:]) - np.mean(logs[:at]))
    if not math.log(TWICE) < apart < math.log(2.0 * TWICE) or logs[at] - logs[at - 1] < 2.0 * spread:
        return None
    return wide[:at], wide[at:]


def _wide(runs: list[Evidence], log: Sequence[Evidence]) -> list[Evidence]:
    """Return the runs whose movement is wide: one of a part of the range may stay within presliding and rub too little."""
    widest = max(e.ranges[0].span for e in log)
    return [e for e in runs if e.ranges[0].span > WIDE * widest]


def _alone(known: list[Evidence], log: Sequence[Evidence]) -> Iterator[Remark]:
    """Yield what the size alone says, where no bend shows the slopes of both systems."""
    # a second pass that swallows the motion has no slopes, but tells that the first one is single
    beside: dict[object, list[Evidence]] = {}
    for o in log:
        beside.setdefault((o.config_id, o.location), []).append(o)
    single = [e for e in known if e.system == "act" and not any(_swallows(o, e) for o in beside[e.config_id, e.location])]
    every = all(e.wrap > 0.0 for e in _wide(list(log), log) if e.system == "act")
    if every and _middle(single, "act") > DOUBLE:
        yield from _told([e for e in single if e.wrap > BETWEEN], "remark", "by its size, if this is no bend of more than usual")
    # a bend that has a name was chosen, and may be as slight as anyone likes; of several the slight ones alone show their slopes
    if any(e.config_id is not None for e in log) or len(_wide(known, log)) < len(_wide(list(log), log)):
        return
    double = [e for e in _wide(known, log) if e.system == "sstl"]
    if _middle(double, "sstl") < SINGLE:
        yield from _told(double, "remark", "by its size, if this is no slight bend")


def _swallows(loop: Evidence, e: Evidence) -> bool:
    """Whether a run of the other system on the same bend, if it has a name, passes on less of what it is driven by."""
    passed = [o.ranges[1].span / max(o.ranges[0].span, 1e-300) for o in (loop, e)]
    return e.config_id is not None and loop.usable and loop.system == "sstl" and passed[0] < passed[1]


def _shuffled(wrong: list[Evidence], pairs: list[list[Evidence]]) -> bool:
    """Whether runs of both systems are wrong beside runs of their bend and system that are right: no exchange of two labels makes that."""
    names_of = {e.run_id for e in wrong}
    right = {(e.config_id, e.location, e.system) for bend in pairs for e in bend if e.run_id not in names_of}
    return len({e.system for e in wrong if (e.config_id, e.location, e.system) in right}) == 2


def _told(wrong: list[Evidence], severity: Severity, by: str, shuffled: bool = False, known: Sequence[Evidence] = ()) -> Iterator[Remark]:
    for system, like, right in (("act", "a double pass", "sstl"), ("sstl", "a single pass", "act")):
        hit = [e for e in wrong if e.system == system]
        if hit:
            e = hit[0]
            ids = tuple(h.run_id for h in hit)
            why, mend = "the label of the system is probably wrong", f'[constants] system = "{right}"'
            if system == "sstl":
                # the cable at the far end carries what one pass leaves
                why += ", or the loop was read at its far end, before its way back"
                mend += " (or tension_out_n = { column = (the sensor where the loop comes back) })"
            if _elsewhere(hit, known):
                why = "the label of its configuration or of its system is probably wrong, or the file is of another rig"
                mend = f'file_name or a manifest with the right config_id, or [constants] system = "{right}"'
            if shuffled:
                why += (
                    ", and as runs of both systems are wrong beside others that are right, the labels of the files were probably shuffled"
                )
                mend = "file_name or manifest (the labels of each file anew: config_id, system, trajectory)"
            yield Remark(
                ids, RULE, severity, e.wrap_about, "1",
                f"{names(ids)}: labelled {system}, but {_slopes(e)} (n theta = {e.wrap_about:.2f}) look like {like} {by}; {why}",
                mend,
            )  # fmt: skip


def _elsewhere(hit: list[Evidence], known: Sequence[Evidence]) -> bool:
    """Whether runs of one configuration are wrong while the label of the system is right in others: then it may be the configuration that is not theirs."""
    ids = {e.run_id for e in hit}
    return len({(e.config_id, e.location) for e in hit}) == 1 and any(o.system == hit[0].system and o.run_id not in ids for o in known)


def _slopes(e: Evidence) -> str:
    if not e.wrap > 0.0 and e.wrap_about > 0.0:
        return "the loops"
    if not e.wrap > 0.0:
        return "what passes on to the output"
    if e.slopes.known or e.play is None:
        return f"slopes of {e.slopes.gamma_p:.3g} and {e.slopes.gamma_r:.3g}"
    return f"slopes of {e.play.gamma_p:.3g} in the pull"
