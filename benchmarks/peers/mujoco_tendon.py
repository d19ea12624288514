"""A tendon with friction loss in MuJoCo: a carriage on a load spring, pulled by a motor through the tendon."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from mujoco import rollout
from numpy.typing import NDArray

Array = NDArray[np.float64]

XML = """
<mujoco model="tendon">
  <option timestep="{dt}" integrator="implicitfast" gravity="0 0 0"><flag contact="disable"/></option>
  <worldbody>
    <body name="carriage">
      <inertial pos="0 0 0" mass="{mass}" diaginertia="0.001 0.001 0.001"/>
      <joint name="slide" type="slide" axis="1 0 0" stiffness="{stiffness}" damping="{damping}"/>
      <geom type="sphere" size="0.01"/>
    </body>
  </worldbody>
  <tendon><fixed name="tendon" frictionloss="{friction}"><joint joint="slide" coef="1"/></fixed></tendon>
  <actuator><motor name="pull" tendon="tendon"/></actuator>
  <sensor><jointpos name="position" joint="slide"/></sensor>
</mujoco>
"""


def chain_xml(dt: float, nodes: int, stiffness: float, friction: float, damping: float) -> str:
    """Return a tendon of several carriages joined by springs, each with its own friction loss, as text."""
    names = range(nodes)
    bodies = "".join(
        f'<body name="c{i}" pos="0 {i} 0"><inertial pos="0 0 0" mass="0.5" diaginertia="0.001 0.001 0.001"/>'
        f'<joint name="s{i}" type="slide" axis="1 0 0" damping="{damping}"'
        f' stiffness="{stiffness if i == nodes - 1 else 0.0}"/><geom type="sphere" size="0.01"/></body>'
        for i in names
    )
    losses = "".join(f'<fixed name="f{i}" frictionloss="{friction / nodes}"><joint joint="s{i}" coef="1"/></fixed>' for i in names)
    springs = "".join(
        f'<fixed name="k{i}" stiffness="{2 * stiffness}"><joint joint="s{i}" coef="1"/><joint joint="s{i + 1}" coef="-1"/></fixed>'
        for i in range(nodes - 1)
    )
    return (
        f'<mujoco model="chain"><option timestep="{dt}" integrator="implicitfast" gravity="0 0 0">'
        f'<flag contact="disable"/></option><worldbody>{bodies}</worldbody><tendon>{losses}{springs}</tendon>'
        f'<actuator><motor name="pull" joint="s0"/></actuator>'
        f'<sensor><jointpos name="position" joint="s{nodes - 1}"/></sensor></mujoco>'
    )


def xml(dt: float, stiffness: float = 8000.0, friction: float = 2.0, damping: float = 20.0, mass: float = 0.05) -> str:
    """Return the model as text."""
    return XML.format(dt=dt, stiffness=stiffness, friction=friction, damping=damping, mass=mass)


class Tendon:
    """The model, compiled once; ``step`` marches it through an input tension in MuJoCo's own compiled loop."""

    def __init__(self, text: str) -> None:
        self.model: Any = mujoco.MjModel.from_xml_string(text)
        self.data: Any = mujoco.MjData(self.model)

    def rest(self) -> Array:
        """Return the state at rest, shape (1, states)."""
        size = mujoco.mj_stateSize(self.model, mujoco.mjtState.mjSTATE_FULLPHYSICS)
        state = np.empty(size)
        mujoco.mj_getState(self.model, self.data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
        return state[None]

    def step(self, tension: Array) -> Array:
        """Return the displacement (m, shape (n,)) for an input tension (N, shape (n,))."""
        mujoco.mj_resetData(self.model, self.data)
        _, sensors = rollout.rollout(self.model, self.data, self.rest(), tension[None, :, None])
        return np.asarray(sensors[0, :, 0])
