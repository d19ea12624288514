"""What an effect of the bristle simulator declares, and what it may change: the parts before a run, the readings after it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sstl_cli.physics.bristle.chain import Chain, Load
from sstl_cli.physics.bristle.contact import Contact, ContactLaw
from sstl_cli.physics.bristle.march import Setting
from sstl_cli.physics.bristle.spec import BristleRun, BristleSpec
from sstl_cli.physics.given import Bounds

FloatArray = NDArray[np.float64]
Values = Mapping[str, float]


@dataclass
class Parts:
    """The simulator as the stepping will see it, plain until effects change what is theirs; M nodes, units mm, N, s.

    `lengths` (M + 1,) are those of the springs; `weights` (M,) the shares of the bend; `sheathed` (M,) is false at the pulley.
    `command` and `swell`, the wrap angle over that without other tendons, have a value a sample.
    """

    spec: BristleSpec
    run: BristleRun
    lengths: FloatArray
    weights: FloatArray
    sheathed: NDArray[np.bool_]
    chain: Chain
    contact: Contact
    load: Load
    law: ContactLaw
    setting: Setting
    command: FloatArray
    swell: FloatArray


@dataclass
class Reading:
    """What sensors and recorder make of one run, sample by sample: tensions (N), position (mm) and time stamps (s).

    The zeros (N) are added once all sensors have been asked. `late_s` is how much later than stamped the output is read; the two
    generators are those of the recorder's clock and its faults.
    """

    system: str
    time: FloatArray
    t_in: FloatArray
    t_out: FloatArray
    x: FloatArray
    stamps: FloatArray
    clock: np.random.Generator
    faults: np.random.Generator
    zero_in: float | FloatArray = 0.0
    zero_out: float | FloatArray = 0.0
    late_s: float = 0.0


def unchanged(_part: Parts | Reading, _values: Values) -> None:
    """Leave everything as it is."""


@dataclass(frozen=True)
class Effect:
    """Code of the bristle simulator for one effect, which at the neutral values of its parameters changes nothing.

    `build` changes the parts; `sense` the signals and zeros of the sensors; `sample` what the recorder reads of them, and when;
    `store` what the converter makes of that, noise included. Effects act in their `order`.
    """

    parameters: Mapping[str, Bounds]
    order: int = 50
    build: Callable[[Parts, Values], None] = unchanged
    sense: Callable[[Reading, Values], None] = unchanged
    sample: Callable[[Reading, Values], None] = unchanged
    store: Callable[[Reading, Values], None] = unchanged
