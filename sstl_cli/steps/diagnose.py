"""Diagnose the gap between recorded runs and a simulator: where, which effect, how far, what next."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ContextDecorator
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import Any

from threadpoolctl import threadpool_limits

from sstl_cli.core.deadline import Deadline
from sstl_cli.core.documents.diagnosis import DiagnosisDocument, Downstream, OddRun, Tracked
from sstl_cli.core.documents.gate import Remark
from sstl_cli.core.errors import SstlError, UsageError
from sstl_cli.core.provenance import by_another
from sstl_cli.core.runs import Run
from sstl_cli.diagnosis import following, gathering, left_out, scaling, verdict, worth
from sstl_cli.diagnosis.accepted import accepted, known, model
from sstl_cli.diagnosis.fit import Fit
from sstl_cli.diagnosis.gathering import Evidence
from sstl_cli.diagnosis.own_record import tried
from sstl_cli.diagnosis.question import Question
from sstl_cli.identification import gate
from sstl_cli.identification.gate.rules import limit, overflow
from sstl_cli.physics.effects import get
from sstl_cli.physics.scenario import Scenario
from sstl_cli.steps.diagnose_document import document, units_of
from sstl_cli.steps.diagnose_given import Given

# a stage that a limit on time may leave out
DOWNSTREAM = "downstream"
# the matrices are small, and threads of a linear algebra wait for those of the workers: two diagnoses side by side took 1.5 times as long
ONE_THREAD: ContextDecorator = threadpool_limits.wrap(limits=1, user_api="blas")


@dataclass(frozen=True)
class DiagnoseOptions(Question):
    """What to compare, the user's own odds, and what else is said of it.

    ``odd_runs`` asks for the runs without which the verdict differs; after ``max_seconds`` no further stage begins that can be
    left out.
    """

    prior: Mapping[str, float] = field(default_factory=dict)
    physics: bool = True
    max_tension_n: float | None = None
    max_rate_n_per_s: float | None = None
    odd_runs: bool = False
    max_seconds: float | None = None


@dataclass(frozen=True)
class Diagnosis:
    """A finished diagnosis; ``document()`` is its JSON form, ``model()`` the accepted simulator."""

    evidence: Evidence
    verdict: verdict.Verdict
    options: DiagnoseOptions
    body: DiagnosisDocument

    def document(self) -> dict[str, Any]:
        """Return the diagnosis as its JSON is written from it, as laid down in the contract."""
        return self.body.plain()

    @property
    def accepted(self) -> Fit:
        """The fit of the accepted model: the named effects, or the re-tuned base where none is named."""
        return accepted(self.evidence, self.verdict)

    def model(self) -> Scenario:
        """Return the accepted simulator, effects included, with what it is known to leave; in the units of the recording."""
        return self._known

    @cached_property
    def _known(self) -> Scenario:
        return tried(self.evidence, known(self.evidence, self.verdict, self.given), self.options)

    def bare(self) -> Scenario:
        """Return the accepted simulator without what it is known to leave."""
        return model(self.evidence, self.verdict, self.given)

    @property
    def given(self) -> Scenario:
        """The simulator that was given, or the one that was assumed."""
        return self.options.given(self.evidence.problem.unit_n)


def odds(table: Mapping[str, Any], where: str) -> dict[str, float]:
    """Return the user's odds of effects from a TOML table ``effect = number``.

    Raises
    ------
    UsageError
        Where one is no positive number, or of no effect of the catalogue.
    """
    found = {}
    for effect_id, value in table.items():
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < float("inf"):
            raise UsageError(f"'{effect_id}' is {value!r}, not a positive number", where=where, code="E903")
        try:
            found[get(effect_id).id] = float(value)
        except SstlError as error:
            raise UsageError(error.what, where=where, fix=error.fix, code=error.code) from None
    return found


@ONE_THREAD
def run(
    runs: Sequence[Run], options: DiagnoseOptions, advance: Callable[[float], None] = lambda _: None, since: float | None = None
) -> Diagnosis:
    """Return the diagnosis of recorded runs.

    Parameters
    ----------
    since : float, optional
        When the clock of ``max_seconds`` began (``time.monotonic``; default: now).

    Raises
    ------
    SstlError
        If no run can be used.
    """
    remarks = _to_answer(gate.remarks(runs)) if options.physics else ()
    runs, failed = _passed(runs, remarks)
    deadline = Deadline(options.max_seconds, since)
    found = gathering.gather(runs, options, advance, deadline.passed)
    found.problem.set_aside.update(failed)
    said = verdict.verdict(found.rows, options.weights, options.prior or None)
    body = document(
        Given(
            **vars(found),
            verdict=said,
            accepted=accepted(found, said),
            remarks=[Remark(**asdict(r)) for r in remarks],
            limits=following.Limits(options.max_tension_n, options.max_rate_n_per_s),
            passed=deadline.passed,
            shows_d2=options.weights.shows_d2,
        )
    )
    result = Diagnosis(found, said, options, body)
    task, notes = _downstream(result, deadline)
    if options.odd_runs:
        body = body.model_copy(update={"verdict": body.verdict.model_copy(update={"odd_runs": _odd_runs(result, deadline)})})
    notes += [*by_another(options.sim and options.sim.package_version, "the simulator"), *_unsaid(options.sim), *deadline.notes]
    more: dict[str, object] = {"notes": [*(body.notes or []), *notes]} | ({} if task is None else {"downstream": task})
    return replace(result, body=body.model_copy(update=more))


def _unsaid(sim: Scenario | None) -> list[str]:
    """Return what a saved simulator should say and does not."""
    if sim is None or not sim.misfits or sim.wander is not None:
        return []
    return ["the simulator does not say how much the rig varies, which may be taken for a change: save it again with --save-sim"]


def _to_answer(remarks: Sequence[gate.Remark]) -> tuple[gate.Remark, ...]:
    """Return the remarks, a sensor beyond its range as no failure: what it hides is left out reading by reading, and it is one of the answers."""
    return tuple(replace(r, severity="remark") if r.rule in (limit.RULE, overflow.RULE) else r for r in remarks)


def _passed(runs: Sequence[Run], remarks: Sequence[gate.Remark]) -> tuple[list[Run], dict[str, str]]:
    """Return the runs that the gate of the physics lets through, and why the others are set aside."""
    failed = {i: r.sentence for r in remarks if r.failed for i in r.run_ids}
    kept = [r for r in runs if r.run_id not in failed]
    if failed and not kept:
        first = next(r for r in remarks if r.failed)
        raise SstlError(
            f"no run passes the gate of the physics: {first.sentence}", fix=f"{first.mend}; --no-physics if you know better", code="E902"
        )
    return kept, failed


def _odd_runs(result: Diagnosis, deadline: Deadline) -> list[OddRun] | None:
    """Return the runs without which the verdict differs, and what it is then; None where that was not looked at."""
    prior = result.options.prior or None
    found = left_out.differing(result.evidence, result.verdict, result.options, prior, deadline.passed)
    if found is None:
        return None
    return [OddRun(run_id=x.run_id, status=x.verdict.status, effects=list(x.verdict.effects)) for x in found]


def _downstream(result: Diagnosis, deadline: Deadline) -> tuple[Downstream | None, list[str]]:
    """Return what the named effect is worth to a controller; or why that is not known."""
    fitted = result.accepted
    if not worth.can_be_asked(result.evidence, fitted) or deadline.passed(DOWNSTREAM):
        return None, []
    try:
        name, found = worth.of_the_middle(result.evidence, fitted, result.bare(), result.given)
    except SstlError as error:
        return None, [f"downstream: {error.what}"]
    tracked = [Tracked(reference=t.reference, rmse_without_n=t.rmse_without_n, rmse_with_n=t.rmse_with_n) for t in found]
    return scaling.restored(Downstream(config_id=name, tracking=tracked), units_of(result.evidence)), []
