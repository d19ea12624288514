"""A rig and what it records, described in one TOML file: mechanics, sensors, configurations, trajectories."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

from sstl_cli.core.config import Model, parse, read_toml
from sstl_cli.core.errors import SstlError, nearest
from sstl_cli.physics.effect import NOMINAL_THETA, Mechanics
from sstl_cli.physics.effects import get

System = Literal["act", "sstl"]
Positive = Annotated[float, Field(gt=0)]
# the largest tension of a movement (N)
HIGHEST_N = 1000.0


class RigSection(Model):
    """Tube and tendon: lengths in mm, stiffness in N and N/mm."""

    length_mm: Annotated[float, Field(ge=10, le=20_000)] = 2000.0
    ea_n: Annotated[float, Field(gt=0, le=1e12)] = 8000.0
    load_n_per_mm: Annotated[float, Field(gt=0, le=1e12)] = 8.0
    arc_fraction: Annotated[float, Field(gt=0, le=1)] = 0.25
    bend_centres: dict[str, Annotated[float, Field(ge=0, le=1)]] = {"NP": 0.2, "CP": 0.5, "ND": 0.8}
    nodes: Annotated[int, Field(ge=5, le=200)] = 30
    loop_friction: Annotated[float, Field(gt=0, le=100, description="friction of the sensing loop over that of the actuation tendon")] = 1.0
    loop_load_n_per_mm: Annotated[
        float | None, Field(gt=0, le=1e12, description="stiffness of what the sensing loop ends at; that of the load where it is not given")
    ] = None
    preload_n: Annotated[
        dict[Literal["act", "sstl"], Annotated[float, Field(ge=0, le=1e12)]] | None,
        Field(description="tension (N) of a pair that pulls both ways, by system; readings are beyond it (fast model alone)"),
    ] = None

    @model_validator(mode="after")
    def _bend_inside_the_tube(self) -> RigSection:
        for name, centre in self.bend_centres.items():
            if centre - self.arc_fraction / 2 < -1e-9 or centre + self.arc_fraction / 2 > 1 + 1e-9:
                raise ValueError(f"the bend of {name} (centre {centre:g}, arc {self.arc_fraction:g} of the length) leaves the tube")
        return self

    def mechanics(self) -> Mechanics:
        """Return the mechanics that both simulators share."""
        own = (self.length_mm, self.ea_n, self.load_n_per_mm, self.arc_fraction, self.bend_centres, self.loop_friction)
        return Mechanics(*own, self.loop_load_n_per_mm, {str(system): n for system, n in (self.preload_n or {}).items()})


class NoiseSection(Model):
    """Noise of each tension sensor: white and coloured standard deviations (N), correlation time (s)."""

    white_n: Annotated[float, Field(ge=0, le=1e12)] = 0.02
    coloured_n: Annotated[float, Field(ge=0, le=1e12)] = 0.0
    correlation_s: Positive = 0.3


class Lines(Model):
    """Propagation lines given directly instead of theta: slopes and biases (N) of one system."""

    gamma_p: Positive
    beta_p: float
    gamma_r: Positive
    beta_r: float


class Configuration(Model):
    """One bend: theta (rad) per pass, or the propagation lines of each system."""

    id: str
    location: str | None = None
    lead_mm: float | None = None
    theta: Annotated[float, Field(ge=0, le=5)] | None = None
    act: Lines | None = None
    sstl: Lines | None = None

    @model_validator(mode="after")
    def _one_description(self) -> Configuration:
        if self.theta is None and self.act is None and self.sstl is None:
            raise ValueError("give theta, or the lines of act and/or sstl")
        return self


class Trajectory(Model):
    """One movement of the input; tensions in N, times in s."""

    kind: Literal["trapezoid", "sinusoid", "random", "ramp_hold", "minor_loops", "chirp"]
    label: str | None = None
    systems: tuple[System, ...] = ("act", "sstl")
    duration_s: Annotated[float, Field(gt=0, le=1e6)] | None = None
    low_n: Annotated[float, Field(ge=-HIGHEST_N, le=HIGHEST_N)] | None = None
    high_n: Annotated[float, Field(gt=0, le=HIGHEST_N)] | None = None
    frequency_hz: Positive | None = None
    top_frequency_hz: Positive | None = None
    speed: Positive = 1.0
    cycles: Annotated[int, Field(ge=1, le=100_000)] | None = None
    hold_s: Annotated[float, Field(ge=0)] | None = None
    drive: Literal["tension", "position"] | None = None
    record_reference: bool = False
    record_position: bool = False

    @property
    def name(self) -> str:
        return self.label or self.kind


class Tendon(Model):
    """One actuation tendon of several: its wrap angle over the configuration's, and how its movement differs.

    It moves like the trajectory, ``level`` times as far and ``delay_s`` (s) later.
    """

    id: Annotated[str, Field(min_length=1)]
    theta_factor: Annotated[float, Field(gt=0, le=3)] = 1.0
    level: Annotated[float, Field(gt=0, le=10)] = 1.0
    delay_s: Annotated[float, Field(ge=0, le=1e6)] = 0.0


class MisfitSection(Model):
    """What an accepted model left of one system and bend: a map over the rig's state, and the scatter about it.

    ``mean_n`` (N) has a value for every knot of the input (N), and in it for every knot of ``other``: the distance from the
    last reversal (N) or the position (mm); pulling first, then releasing. ``sd_n`` (N) is the scatter at the same places,
    ``doubt_n`` (N) columns of a factor of the covariance of ``mean_n``, ``size_n`` (N) how large such maps are, ``rate_n_s``
    (N/s) the fastest that the input has gone up and down. The scatter is alike over ``correlation_s``, and on the move over
    ``correlation_path`` (N of the input, or mm), and comes in jerks as Student's distribution of ``tail`` degrees of freedom.
    """

    system: System
    config_id: str
    along: Literal["turning", "position"]
    correlation_s: Positive
    input_n: tuple[float, ...]
    other: tuple[float, ...]
    mean_n: tuple[float, ...]
    sd_n: tuple[float, ...]
    size_n: Annotated[float, Field(ge=0)] = 0.0
    doubt_n: tuple[tuple[float, ...], ...] = ()
    correlation_path: Positive | None = None
    tail: Positive | None = None
    rate_n_s: tuple[float, float] | None = None

    @model_validator(mode="after")
    def _one_value_a_knot(self) -> MisfitSection:
        if not len(self.mean_n) == len(self.sd_n) == 2 * len(self.input_n) * len(self.other):
            raise ValueError("mean_n and sd_n need a value for every pair of knots, pulling and releasing")
        if any(len(c) != len(self.mean_n) for c in self.doubt_n):
            raise ValueError("every column of doubt_n needs as many values as mean_n")
        return self


class Variation(Model):
    """Standard deviations of theta and of strengths, in their units; shapes beside them are held as they stand there."""

    theta: Annotated[float, Field(ge=0)] = 0.0
    effects: dict[str, dict[str, float]] = {}


class WanderSection(Model):
    """How an accepted model varied about itself: from stretch to stretch of its record, from run to run, and as a whole."""

    stretch_s: Positive
    stretch: Variation = Variation()
    run: Variation = Variation()
    whole: Variation = Variation()


class OutputScale(Model):
    """Output in another unit than newtons: units a newton and origin (in the unit) of each system."""

    unit: str
    per_n: dict[str, Positive]
    origin: dict[str, float]


class Scenario(Model):
    """A rig, its sensors, its configurations, what is recorded, and the effects it contains."""

    schema_id: Literal["sstl.scenario/1"] = Field("sstl.scenario/1", alias="schema")
    simulator: Literal["transmission", "rig", "bristle", "variant"] = "transmission"
    sampling_hz: Annotated[float, Field(gt=0, le=1e5)] = 500.0
    generator: Literal["paper-cp40", "paper-150"] | None = None
    rig: RigSection = RigSection()
    noise: NoiseSection = NoiseSection()
    configurations: tuple[Configuration, ...] = ()
    trajectories: tuple[Trajectory, ...] = ()
    tendons: tuple[Tendon, ...] = ()
    effects: dict[str, dict[str, float]] = {}
    # law of an effect by its name where the simulator is `variant`; drawn from the seed where not given
    laws: dict[str, str] = {}
    # of an accepted model: what it left of its record, and the scale of an output that is no force
    misfits: tuple[MisfitSection, ...] = ()
    wander: WanderSection | None = None
    # squared error (N^2) a reading that faults of the recorder carried in its record, and chance could as well have brought
    faults: dict[str, float] = {}
    # tests of what is left beyond map and scatter: by how much they exceed chance on the model's own record (overdispersion)
    dispersion: dict[str, float] = {}
    output: OutputScale | None = None
    package_version: str | None = Field(None, description="version of sstl that accepted it")

    @model_validator(mode="after")
    def _known_effects(self) -> Scenario:
        for effect_id, values in self.effects.items():
            get(effect_id).complete(values)
        ids = [c.id for c in self.configurations]
        if len(set(ids)) != len(ids):
            raise ValueError("two configurations have the same id")
        self._pulled()
        names = [t.id for t in self.tendons]
        if len(set(names)) != len(names):
            raise ValueError("two tendons have the same id")
        return self

    def _pulled(self) -> None:
        """Raise ValueError where a tendon would have to push."""
        mechanics = self.rig.mechanics()
        if self.simulator != "transmission" and any(mechanics.preload_n.values()):
            raise ValueError('a preload_n is known to the fast model alone (simulator = "transmission")')
        for t in self.trajectories:
            least = 0.0 - min((mechanics.preload(system) for system in t.systems), default=0.0)
            if t.low_n is not None and t.low_n < least:
                raise ValueError(
                    f"low_n of trajectory {t.name} is below {least:g} N, and a tendon cannot push; a preload_n in [rig] lowers that"
                )

    def with_rig(self, **changes: float | Mapping[str, float] | None) -> Scenario:
        """Return the scenario of a rig that differs in some of its numbers."""
        return self.model_copy(update={"rig": self.rig.model_copy(update=changes)})

    def theta_of(self, config_id: str | None) -> float:
        """Return the nominal theta of a configuration (rad), 0.53 where the file gives none."""
        for c in self.configurations:
            if c.id == config_id and c.theta is not None:
                return c.theta
        known = [c.theta for c in self.configurations if c.theta is not None]
        return sum(known) / len(known) if known else NOMINAL_THETA


def builtin_names() -> list[str]:
    """Return the names of the scenarios that come with the package."""
    folder = resources.files("sstl_cli.physics") / "scenarios"
    return sorted(p.name.removesuffix(".toml") for p in folder.iterdir() if p.name.endswith(".toml"))


def load(name_or_path: str) -> Scenario:
    """Return a scenario from a TOML file, or one that comes with the package by its name.

    Raises
    ------
    SstlError
        If there is no such file or name, or a value does not fit; the line names the key.
    """
    path = Path(name_or_path)
    if path.suffix == ".toml" or path.exists():
        return parse(Scenario, read_toml(path), str(path))
    if name_or_path not in builtin_names():
        raise SstlError(
            f"no scenario '{name_or_path}' ({nearest(name_or_path, builtin_names())})",
            fix="give a TOML file or a built-in name",
            code="E710",
        )
    with resources.as_file(resources.files("sstl_cli.physics") / "scenarios" / f"{name_or_path}.toml") as file:
        return parse(Scenario, read_toml(file), name_or_path)
