"""Tensions far from those of the catalogue's ranges, brought there for the fit and back for the answer."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from sstl_cli.core.documents.base import Part
from sstl_cli.core.documents.quantity import Quantity
from sstl_cli.core.runs import Run
from sstl_cli.diagnosis.constants import HIGH_N, LOW_N, TARGET_N, UNSEEN_SHARE
from sstl_cli.diagnosis.neighbours import NEIGHBOUR
from sstl_cli.diagnosis.scale import Scale
from sstl_cli.physics.effect import Mechanics
from sstl_cli.physics.effects import get
from sstl_cli.physics.scenario import Scenario

POWERS = {"N": 1, "N s/mm": 1, "1/N": -1, "mm/N": -1, "1/kN": -1, "s/N": -1, "s/N^2": -2}


def unit_of(runs: Sequence[Run]) -> float:
    """Return how many N of the recording are one N of the fit: 1 within 3-60 N, else a round number."""
    # above the top are spikes
    tops = [np.nanquantile(np.abs(r.tension_in_n), 1.0 - UNSEEN_SHARE) for r in runs if np.isfinite(r.tension_in_n).any()]
    top = float(max(tops, default=TARGET_N))
    if LOW_N <= top <= HIGH_N or top == 0.0:
        return 1.0
    return float(f"{top / TARGET_N:.2g}")


def scaled(runs: Sequence[Run], unit_n: float) -> list[Run]:
    """Return runs with their tensions in units of ``unit_n`` (N)."""
    if unit_n == 1.0:
        return list(runs)
    return [
        replace(
            r,
            tension_in_n=r.tension_in_n / unit_n,
            tension_out_n=r.tension_out_n / unit_n,
            tension_ref_n=None if r.tension_ref_n is None else r.tension_ref_n / unit_n,
            extra={k: v / unit_n if k == NEIGHBOUR else v for k, v in r.extra.items()},
        )
        for r in runs
    ]


def unit_factor(unit: str | None, unit_n: float) -> float:
    """Return how many of the recording's are one of the scaled fit, of a quantity with a unit."""
    return unit_n ** POWERS.get(unit or "", 0)


def parameter(value: float, unit: str, unit_n: float) -> float:
    """Return a parameter of the scaled fit in the units of the recording."""
    return value * unit_factor(unit, unit_n)


def in_recording(effect_id: str, values: Mapping[str, float], unit_n: float) -> dict[str, float]:
    """Return the parameters of an effect of the scaled fit in the units of the recording."""
    return {k: v * own for k, v, own in _with_factors(effect_id, values, unit_n)}


def effects(simulator: Scenario, unit_n: float) -> dict[str, dict[str, float]]:
    """Return the effects of a simulator, given in the units of the recording, in those of the scaled fit."""
    return {e: {k: v / own for k, v, own in _with_factors(e, values, unit_n)} for e, values in simulator.effects.items()}


def _with_factors(effect_id: str, values: Mapping[str, float], unit_n: float) -> list[tuple[str, float, float]]:
    """Return the parameters of an effect by name, each with the factor between the scaled fit and the recording."""
    effect = get(effect_id)
    return [(k, v, unit_factor(effect.parameter(k).unit, unit_n)) for k, v in values.items()]


def mechanics(simulator: Scenario, unit_n: float) -> Mechanics:
    """Return the mechanics of a simulator, given in the units of the recording, in those of the scaled fit."""
    own = simulator.rig.mechanics()
    loop = None if own.loop_load_n_per_mm is None else own.loop_load_n_per_mm / unit_n
    preload_n = {system: p / unit_n for system, p in own.preload_n.items()}
    return replace(own, ea_n=own.ea_n / unit_n, load_n_per_mm=own.load_n_per_mm / unit_n, loop_load_n_per_mm=loop, preload_n=preload_n)


def in_proportion(unit_n: float) -> Scenario:
    """Return the simulator of a rig that nothing is known of: the usual one, as much stiffer as its tensions are larger."""
    usual = Scenario()
    return usual.with_rig(ea_n=usual.rig.ea_n * unit_n, load_n_per_mm=usual.rig.load_n_per_mm * unit_n)


@dataclass(frozen=True)
class Units:
    """The units of a recording: how many N one N of the fit is, and the scale of an output that is no force."""

    unit_n: float = 1.0
    output: Scale | None = None

    @property
    def systems(self) -> Collection[str]:
        """The systems whose outputs have a scale of their own."""
        return () if self.output is None else self.output.per_n

    def of(self, quantity: Quantity, unit: str | None, system: str | None) -> tuple[float, float]:
        """Return factor and origin that bring a number of the fit to the units of the recording.

        Parameters
        ----------
        unit : str, optional
            What the field ``unit`` beside it says.
        system : str, optional
            The system that it is of; what is of several goes by the typical scale.
        """
        if quantity is Quantity.OWN:
            return unit_factor(unit, self.unit_n), 0.0
        if quantity is Quantity.INPUT or self.output is None:
            return self.unit_n, 0.0
        factor = self.unit_n * self.output.per_n.get(system or "", self.output.typical)
        if quantity is Quantity.OUTPUT:
            return abs(factor), 0.0
        return factor, self.output.origin.get(system or "", 0.0) if quantity is Quantity.READING else 0.0


P = TypeVar("P", bound=Part)


def restored(part: P, units: Units, system: str | None = None) -> P:
    """Return a part of a document in the units of the recording: every field goes as its ``Quantity`` says.

    Parameters
    ----------
    system : str, optional
        The system that the part is of, where it does not say so itself.
    """
    if units == Units():
        return part
    system = getattr(part, "system", None) or system
    changed: dict[str, object] = {}
    for name, field in type(part).model_fields.items():
        value = getattr(part, name)
        quantity = next((m for m in field.metadata if isinstance(m, Quantity)), None)
        if name in part.model_fields_set and value is not None:
            changed[name] = (
                _inside(value, units, system)
                if quantity is None
                else _times(value, *units.of(quantity, getattr(part, "unit", None), system))
            )
    return part.model_copy(update=changed)


def _inside(value: object, units: Units, system: str | None) -> object:
    """Return a field with the parts within it restored; what a dictionary holds by the name of a system is of that system."""
    if isinstance(value, Part):
        return restored(value, units, system)
    if isinstance(value, list | tuple):
        return type(value)(_inside(v, units, system) for v in value)
    if isinstance(value, dict):
        return {k: _inside(v, units, k if k in units.systems else system) for k, v in value.items()}
    return value


def _times(value: float | Sequence[float | None] | None, factor: float, origin: float) -> object:
    """Return a number, or several, times a factor, from an origin; what is not known stays so."""
    if isinstance(value, list | tuple):
        return type(value)(_times(v, factor, origin) for v in value)
    return None if value is None else origin + factor * float(value)  # type: ignore[arg-type]
