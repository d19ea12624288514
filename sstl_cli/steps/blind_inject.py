"""Put known effects into recordings of a real rig and see whether they are named: with the rig's model, and without."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from sstl_cli.blind.inject import Injection, half, injections, put_in
from sstl_cli.core.documents.blind_real import BlindInjectDocument, Injected, InjectedScore
from sstl_cli.core.documents.diagnosis import DiagnosisDocument
from sstl_cli.core.groups import spelled_out
from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.constants import DECIDABLE
from sstl_cli.physics.effects import get
from sstl_cli.physics.scenario import Scenario
from sstl_cli.steps import diagnose_tendons
from sstl_cli.steps.diagnose import DiagnoseOptions

# sizes count as right within this share
CLOSE = 0.2
DETECTED_NATS = DECIDABLE / 2.0


def run(
    logs: Mapping[str, Sequence[Run]],
    asked: Mapping[str, float] | None,
    without: bool = True,
    max_effects: int = 2,
    advance: Callable[[float], None] = lambda _: None,
) -> BlindInjectDocument:
    """Return for each log what is said of its untouched second half and of effects put into that half.

    The model is accepted on the first half, so that nothing is judged on samples it was fitted to.

    Parameters
    ----------
    asked : mapping, optional
        Effects and sizes; all known operations at the usual share of the span where None.
    without : bool
        Whether to diagnose without the rig's model too.
    """
    rows: list[Injected] = []
    for name, runs in logs.items():
        first, second = [half(r, False) for r in runs], [half(r, True) for r in runs]
        options = DiagnoseOptions(max_effects=max_effects)
        model = diagnose_tendons.run(first, options).model()
        advance(1)
        for known in (True, False) if without else (True,):
            sim = model if known else None
            before = _said(second, sim, max_effects)
            advance(1)
            rows.append(_row(name, known, None, before))
            for injection in injections(second, asked):
                rows.append(_row(name, known, injection, _said(put_in(second, injection), sim, max_effects)))
                advance(1)
    return scored(rows)


def scored(rows: Sequence[Injected]) -> BlindInjectDocument:
    """Return rows with their scores."""
    without = any(not r.with_model for r in rows)
    return BlindInjectDocument(
        schema="sstl.blind.inject/1",
        rows=list(rows),
        with_model=_score(rows, True),
        without_model=_score(rows, False) if without else None,
        inputs={},
    )


def _said(runs: Sequence[Run], sim: Scenario | None, max_effects: int) -> DiagnosisDocument:
    return diagnose_tendons.run(list(runs), DiagnoseOptions(sim=sim, max_effects=max_effects)).body


def _row(log: str, known: bool, put: Injection | None, said: DiagnosisDocument) -> Injected:
    verdict = said.verdict
    effects, committed = list(verdict.effects), verdict.status == "identified"
    row = Injected(
        log=log,
        with_model=known,
        effect=None if put is None else put.effect,
        size=None if put is None else put.size,
        status=verdict.status,
        effects=effects,
        ambiguity_group=verdict.ambiguity_group,
        shrink_pct=said.gap.shrink_pct,
        estimate=None,
        decidable=None,
        close=None,
        named=put is not None and committed and effects == [put.effect],
        in_group=put is not None and put.effect in {*effects, *spelled_out(verdict.ambiguity_group, verdict.members)},
        wrong=committed and (put is None or put.effect not in effects),
    )
    own = None if put is None else next((c for c in said.candidates if c.id == put.effect), None)
    if put is None or own is None or own.gain_nats is None:
        return row
    # of several hypotheses of the effect that explain the data as well the one with its parameter counts
    leading = {p.name: p.estimate for p in own.parameters}
    found = next((values[put.parameter] for values in (leading, *(own.alternatives or ())) if put.parameter in values), None)
    neutral = get(put.effect).parameter(put.parameter).neutral
    # parameters of an output in another unit are in newtons all the same
    scaled = said.analysis.output_scale if said.analysis else None
    scale = scaled.per_n.get("act", 1.0) if scaled else 1.0
    size = put.size / scale if get(put.effect).parameter(put.parameter).unit == "N" else put.size
    rivals = [c.d2 for c in said.candidates if c.id != put.effect and c.d2 is not None and "+" not in c.id]
    apart = min(rivals, default=float("inf")) if own.d2 is None else own.d2
    return row.model_copy(
        update={
            "estimate": None if found is None else found - neutral,
            "size_fitted": size,
            "close": found is not None and bool(abs(found - neutral - size) <= CLOSE * abs(size)),
            "decidable": bool(own.gain_nats >= DETECTED_NATS and apart >= DECIDABLE),
        }
    )


def _score(rows: Sequence[Injected], known: bool) -> InjectedScore:
    """Return counts over the rows with or without the rig's model."""
    own = [r for r in rows if r.with_model == known]
    put = [r for r in own if r.effect is not None]
    untouched = [r for r in own if r.effect is None]
    named = [r for r in put if r.named]
    return InjectedScore(
        of=len(put),
        named=len(named),
        in_group=sum(r.in_group for r in put),
        wrong=sum(r.wrong for r in put),
        decidable=sum(bool(r.decidable) for r in put),
        decidable_named=sum(bool(r.decidable) for r in named),
        close=sum(bool(r.close) for r in named),
        untouched=len(untouched),
        untouched_none=sum(r.status == "none" for r in untouched),
        untouched_named=sum(r.status == "identified" for r in untouched),
    )
