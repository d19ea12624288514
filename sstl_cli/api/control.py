"""Compensation from Python: the controller of every configuration along references, scored on its plant."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from sstl_cli.api.mapping import Mapping, table_of
from sstl_cli.control.controller import METHODS, Options
from sstl_cli.control.references import NAMES
from sstl_cli.control.scoring import MAPE_FLOOR_N
from sstl_cli.core.errors import SstlError, nearest
from sstl_cli.physics.scenario import Scenario
from sstl_cli.steps import compensate as compensating
from sstl_cli.steps import compensate_setup as setup


def compensate(
    theta: pd.DataFrame,
    mapping: Mapping | None = None,
    *,
    references: Sequence[str] = ("sinusoid",),
    methods: Sequence[str] | None = None,
    plant: Scenario | None = None,
    cycles: int = 2,
    mape_floor_n: float = MAPE_FLOOR_N,
    seed: int = 0,
) -> pd.DataFrame:
    """Return how well each configuration tracks references, as ``sstl compensate --scores`` writes it.

    Parameters
    ----------
    theta : DataFrame
        Theta table, as ``log.segment()`` returns it; its ``act`` rows are the plants unless another is given.
    mapping : Mapping, optional
        Predicts the actuation slopes from the sensing loop, for the methods ``proposed`` and ``no-bias``.
    references : sequence of str
        Some of sinusoid, random and trapezoid.
    methods : sequence of str, optional
        Some of none, no-bias, proposed and DI; by default those that are possible.
    plant : Scenario, optional
        A simulator as the plant, such as the model of a diagnosis.
    cycles : int
        Cycles of the sinusoid and the trapezoid.
    mape_floor_n : float
        References below this (N) are left out of MAPE.
    seed : int
        Seed of the random reference.

    Raises
    ------
    SstlError
        For an unknown reference or method, one that is not possible, or without a configuration that has a plant.

    Examples
    --------
    >>> from sstl_cli.api.log import simulate
    >>> scores = compensate(simulate("sample", seed=1).segment(), methods=["none", "DI"], cycles=1)
    >>> sorted(scores["method"].unique())
    ['DI', 'none']
    """
    for what, given, known, code in (("reference", references, NAMES, "E407"), ("method", methods or (), METHODS, "E404")):
        for name in given:
            if name not in known:
                raise SstlError(f"no {what} '{name}' ({nearest(name, known)})", code=code)
    cases, aside = compensating.cases_of(table_of(theta))
    truth = cases
    if mapping is not None:
        cases, unmapped = setup.mapped_cases(cases, mapping.model, setup.Biases())
        aside.update(unmapped)
    plan = setup.plan(cases, aside, methods or METHODS, methods is not None, setup.plants(truth, plant), "DataFrame")
    options = Options()
    wanted = setup.references_of(references, {}, options.dt_s, cycles, seed)
    done = compensating.run(plan.cases, wanted, plan.plant_of, plan.methods, options, seed, mape_floor_n)
    frame: pd.DataFrame = compensating.score_table([row for result in done for row in compensating.score_rows(result)]).to_pandas()
    return frame
