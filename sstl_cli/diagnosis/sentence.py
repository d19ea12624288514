"""The verdict in one plain sentence, and the few lines under it."""

from __future__ import annotations

from collections.abc import Sequence

from sstl_cli.core.documents.diagnosis import Analysis, DiagnosisDocument, Gap, LeastShown, OddRun, Place, Verdict
from sstl_cli.core.groups import below, error_of, rivals
from sstl_cli.core.numbers import quantity, small
from sstl_cli.diagnosis.by_run import OWN
from sstl_cli.diagnosis.constants import HALF, LISTED, MOST_SURE, PLACES, SENSORS_S
from sstl_cli.physics.effects import catalogue


def sentence(document: DiagnosisDocument) -> str:
    """Return the answer to 'what causes the gap?' in one sentence."""
    verdict, gap = document.verdict, document.gap
    status, sure, left = verdict.status, _sure(verdict.confidence), gap.known_misfit_n
    if status == "none" and _uncertain(verdict):
        what = "has changed since the simulator was accepted" if left else "is missing"
        return f"It is not certain that anything {what}: {verdict.why}{sure}."
    if status == "none" and left:
        unit = document.unit or "N"
        # re-tuned to what is most likely it may leave more than as it was accepted
        least = min((n for n in (gap.rmse_base_n, gap.rmse_retuned_n) if n is not None), default=0.0)
        rest = max(least**2 - (gap.noise_floor_n or 0.0) ** 2, 0.0) ** 0.5
        much = f"{quantity(small(rest), unit)} beyond the noise, where it was {quantity(small(left), unit)}"
        if document.analysis is not None and document.analysis.theta_changed:
            return (
                f"Theta has changed since the simulator was accepted ({_moved(document.analysis)}): the tube bends otherwise, or "
                f"rubs otherwise all along; as far as this data can show nothing else has{sure}."
            )
        return f"As far as this data can show nothing has changed since the simulator was accepted: it leaves {much}{sure}."
    if status == "none":
        slow = _slow(document)
        return f"The simulator already explains the log to its noise floor: nothing is missing that this data could show{slow}{sure}."
    if status == "unknown":
        outputs = _wandering(document, SENSORS_S)
        seen = f"; outputs wander by {', '.join(outputs)}" if outputs else ""
        return f"The cause of the gap is not known: {verdict.why}{seen}{sure}."
    names = " and ".join(e if _plain(e) == e else f"{_plain(e)} ({e})" for e in verdict.effects)
    if status == "ambiguous":
        others = rivals(verdict)
        if _nameless(document):
            more = f", from {_listed(others)}" if others else ""
            return f"{_much(gap)} may come from {names}{more}, or from something that has no name here{sure}."
        them = "it" if len(others) == 1 else "them"
        others_too = f", or from {_listed(others)}: this data does not rule {them} out" if others else ", but that is not certain"
        return f"{_much(gap)} comes most likely from {names}{others_too}{sure}."
    return f"{_much(gap)} comes from {names}{sure}."


def _slow(document: DiagnosisDocument) -> str:
    """Return what passes for slow noise of the outputs where it is more than their white one, empty where it is not.

    A reading that wanders is noise of its sensor or a disturbance, and a record of the two together does not say which.
    """
    slow = _wandering(document, 0.0)
    return f", if what the outputs wander by ({', '.join(slow)}) is noise of their sensors" if slow else ""


def _wandering(document: DiagnosisDocument, longer_s: float) -> list[str]:
    """Return by how much and for how long outputs wander, of those that do so by more than their white noise and for longer than that."""
    noise, unit = document.analysis.noise if document.analysis else {}, document.unit or "N"
    outputs = {system: sensors["output"] for system, sensors in noise.items()}
    return [
        f"{system} {quantity(small(of['coloured_n'].estimate), unit)} for {of['correlation_s'].estimate:.2g} s"
        for system, of in outputs.items()
        if of["coloured_n"].estimate > of["white_n"].estimate and of["correlation_s"].estimate > longer_s
    ]


def _uncertain(verdict: Verdict) -> bool:
    """Whether all effects together are likelier than that nothing is missing, or such an answer is more often wrong than right."""
    nothing, unknown = verdict.probability_none, verdict.probability_unknown
    rather_not = verdict.confidence is not None and verdict.confidence < HALF
    return rather_not or (nothing is not None and nothing < 1.0 - nothing - (unknown or 0.0))


def _nameless(document: DiagnosisDocument) -> bool:
    """Whether something without a name is likelier than any candidate."""
    named = max((c.probability or 0.0 for c in document.candidates), default=0.0)
    return (document.verdict.probability_unknown or 0.0) > named


def _moved(analysis: Analysis) -> str:
    """Return by how much theta has changed, bend by bend, where it is a per cent or more anywhere; of more than it was no per cent."""
    now, before = analysis.theta_with_effect or analysis.theta, analysis.theta_before or {}
    said = []
    for bend, was in before.items():
        by = now[bend] - was
        # per cent of next to nothing say nothing
        share = round(100.0 * by / was) if abs(by) <= was and was else None
        if by and share != 0:
            said.append(f"{bend} {was:.3g} -> {now[bend]:.3g}" + ("" if share is None else f", {share:+d} %"))
    return _listed(said) or "by less than one per cent"


def _much(gap: Gap) -> str:
    """Return how the sentence begins: what explains less than half of what can be explained is not where the gap comes from.

    Of jumps the mean alone is foretold; they are its cause where they account for the rest.
    """
    share, accounted = gap.explained_of_reducible_pct, gap.accounted_pct
    if share is None or share >= 100.0 * HALF:
        return "The gap"
    if accounted is not None and accounted >= 100.0 * HALF:
        return f"{accounted:.0f} % of the gap (squared, beyond the noise, with jumps at moments that nobody can foretell)"
    return (
        f"A part of the gap ({share:.0f} % of the error above {below(gap.known_misfit_n)})"
        if share >= 0.5
        else "Next to nothing of the gap"
    )


def _sure(confidence: float | None) -> str:
    # no library is large enough to promise more
    return "" if confidence is None else f" (right in {min(100.0 * confidence, MOST_SURE):.0f} of 100 such cases)"


def _listed(ids: list[str], most: int = LISTED) -> str:
    return ", ".join(ids[:most]) + (f" and {len(ids) - most} more" if len(ids) > most else "")


def _plain(effect_id: str) -> str:
    title = catalogue()[effect_id].title
    return title[0].lower() + title[1:]


def lines(document: DiagnosisDocument) -> list[str]:
    """Return the lines that a person reads under the sentence."""
    gap, verdict, analysis, unit = document.gap, document.verdict, document.analysis, document.unit or "N"
    out = [_steps(gap, verdict, unit)]
    if verdict.effects:
        out.append(_fall(gap))
    if analysis is not None and analysis.theta_changed and verdict.status != "none":
        well = " as well" if verdict.effects else ""
        out.append(f"  theta has changed{well} since the simulator was accepted: {_moved(analysis)}")
    out.append(_places(document.where))
    if verdict.effects and (rivals(verdict) or verdict.status != "ambiguous"):
        out.append("  not told apart from it on this data: " + (", ".join(rivals(verdict)) or "nothing"))
    out += _beside(document)
    out += _shown(verdict, unit)
    out += [f"  without run {r.run_id}: {_said(r)}" for r in verdict.odd_runs or ()]
    for tracked in document.downstream.tracking if document.downstream else ():
        knowing, other = quantity(small(tracked.rmse_with_n), unit), quantity(small(tracked.rmse_without_n), unit)
        if knowing != other:
            out.append(f"  a controller that knows it tracks the {tracked.reference} reference to {knowing} instead of {other}")
    return out + [f"  note: {text}" for text in document.notes or ()]


def _beside(document: DiagnosisDocument) -> list[str]:
    """Return what most of another channel's error comes from, where the verdict on the output does not say it."""
    other = document.beside
    if other is None or set(other.effects) & set(document.verdict.effects) or (other.shrink_pct or 0.0) < 100.0 * HALF:
        return []
    before, after = (quantity(small(v), other.unit) for v in (other.rmse_base, other.rmse_with_effect))
    names = " and ".join(f"{_plain(e)} ({e})" for e in other.effects)
    return [f"  beside the output: {names} explains channel {other.channel}, whose error falls from {before} to {after}"]


def _steps(gap: Gap, verdict: Verdict, unit: str) -> str:
    """Return the error as given, re-tuned and with the effect, beside what no model can take away."""

    def _n(value: float | None) -> str:
        return quantity(small(value), unit)

    added = f" -> {_n(gap.rmse_with_effect_n)} with the effect" if verdict.effects else ""
    known = f", known misfit {_n(gap.known_misfit_n)}" if gap.known_misfit_n else ""
    # what is most likely beside a known scatter, or noise that is not alike everywhere, need not leave the least RMSE
    likely = "re-tuned (to what is most likely, not to the least RMSE)" if _more(gap.rmse_retuned_n, gap.rmse_base_n) else "re-tuned"
    floor = f"noise floor {_n(gap.noise_floor_n)}"
    return f"  {_n(gap.rmse_base_n)} as given -> {_n(gap.rmse_retuned_n)} {likely}{added}; {floor}{known}"


def _fall(gap: Gap) -> str:
    """Return by how much the error falls, of what it is, and how much of what can be explained that is."""
    why = "what a run has of its own is fitted to it" if gap.held_out_kind == OWN else "no other excitation to hold out"
    held = "held-out error falls" if gap.held_out else f"error falls ({why})"
    if what := error_of(gap.samples):
        held = f"error of {what} falls"
    (low, high), fall, share = gap.shrink_ci95_pct or (None, None), gap.shrink_pct or 0.0, gap.explained_of_reducible_pct
    if round(fall, 1) < 0.0:
        # as of jumps that nobody can foretell: nothing is explained of what is larger than before
        held, fall, share = held.replace("falls", "rises"), -fall, None
        low, high = (None, None) if low is None or high is None else (-high, -low)
    between = "" if low is None or high is None else f" [{low:.1f}, {high:.1f}]"
    of = "" if share is None else f"; {share:.1f} % of the error above {below(gap.known_misfit_n)}"
    return f"  {held} by {fall:.1f} %{between}{of}"


def _places(where: Sequence[Place]) -> str:
    """Return the places that hold most of the error, the bends of each taken together."""
    places: dict[str, float] = {}
    for place in where:
        key = f"{place.system} {place.phase}"
        places[key] = places.get(key, 0.0) + place.share_pct
    top = sorted(places.items(), key=lambda item: -item[1])[:PLACES]
    rest = 100.0 - sum(v for _, v in top)
    return "  it lies in   " + "   ".join(f"{k} {v:.0f} %" for k, v in top) + f"   elsewhere {max(rest, 0.0):.0f} %"


def _more(value: float | None, than: float | None) -> bool:
    """Whether a number is larger than another one as both are written."""
    return value is not None and than is not None and float(f"{value:.2g}") > float(f"{than:.2g}")


def _said(odd: OddRun) -> str:
    """Return a verdict in a few words: the effects, or that there are none."""
    effects = " + ".join(odd.effects)
    return {"none": "nothing is missing", "unknown": "the cause is not known", "ambiguous": f"most likely {effects}, but not for sure"}.get(
        odd.status, effects
    )


def _told(s: LeastShown) -> str:
    """Return from which size an effect would have been told from what looks most like it."""
    if s.rival is None:
        return ""
    if s.told_size is None:
        return f"; not told from {s.rival}"
    return f"; told from {s.rival}" + (f" from {quantity(s.told_size, s.unit)} on" if _more(s.told_size, s.size) else "")


def _shown(verdict: Verdict, unit: str) -> list[str]:
    """Return what would have been seen (nothing found), or what is left (cause unknown)."""
    least = sorted(verdict.would_have_shown or (), key=lambda s: s.gap_n)[:LISTED]
    out = [
        f"  would have shown: {s.effect} ({s.parameter}) from {quantity(s.size, s.unit)} on, a gap of {quantity(small(s.gap_n), unit)}{_told(s)}"
        for s in least
    ]
    left = (verdict.leftover or [])[:2]
    return out + [f"  left over: {t.test}, {t.sigma:.0f} sigma" + (f", at {t.where}" if t.where else "") for t in left]
