"""What an effect of the rig declares, and what it may change: the parts before a run, the readings after it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.physics.given import Bounds
from sstl_cli.physics.rig.chain import Chain, Load, TensionLaw
from sstl_cli.physics.rig.friction import Contact, ContactLaw
from sstl_cli.physics.rig.march import Setting
from sstl_cli.physics.rig.spec import RigRun, RigSpec

FloatArray = NDArray[np.float64]
Values = Mapping[str, float]


@dataclass
class Parts:
    """The rig as the march will see it, plain until effects change what is theirs; M nodes, units mm, N, s.

    `lengths` (M + 1,) are those of the springs; `sheathed` (M,) is false at the pulley. `command` has a value a sample, and so
    has `swell`, the bend angle over that without other tendons, unless it is empty.
    """

    spec: RigSpec
    run: RigRun
    lengths: FloatArray
    sheathed: NDArray[np.bool_]
    chain: Chain
    contact: Contact
    load: Load
    tension_law: TensionLaw
    contact_law: ContactLaw
    setting: Setting
    command: FloatArray
    swell: FloatArray


@dataclass
class Reading:
    """What sensors and recorder make of one run, sample by sample: tensions (N), position (mm) and time stamps (s).

    `late_s` is how much later than stamped the output is read; the two generators are those of the recorder's clock and its faults.
    """

    system: str
    time: FloatArray
    t_in: FloatArray
    t_out: FloatArray
    x: FloatArray
    stamps: FloatArray
    clock: np.random.Generator
    faults: np.random.Generator
    late_s: float = 0.0


def unchanged(_part: Parts | Reading, _values: Values) -> None:
    """Leave everything as it is."""


@dataclass(frozen=True)
class Effect:
    """Code of the rig for one effect, which at the neutral values of its parameters changes nothing.

    `build` changes the parts; `sense` the signals of the sensors, before their noise; `sample` when they are read; `store` what the
    converter and the recorder make of them. Effects act in their `order`.
    """

    parameters: Mapping[str, Bounds]
    order: int = 50
    build: Callable[[Parts, Values], None] = unchanged
    sense: Callable[[Reading, Values], None] = unchanged
    sample: Callable[[Reading, Values], None] = unchanged
    store: Callable[[Reading, Values], None] = unchanged
