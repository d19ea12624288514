"""MuJoCo's system identification: friction loss, stiffness and damping of a tendon fitted to its recorded position."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from mujoco import rollout, sysid

from benchmarks.peers import mujoco_tendon

DT_S = 0.002
TRUE = {"friction": 2.0, "stiffness": 8000.0, "damping": 20.0}


class Fit:
    """A recording with noise, and the fit to it: a single carriage, or ``nodes`` of them with friction each."""

    def __init__(self, samples: int, nodes: int = 1) -> None:
        self.nodes = nodes
        text = mujoco_tendon.xml(DT_S, **TRUE) if nodes == 1 else mujoco_tendon.chain_xml(DT_S, nodes, **TRUE)
        spec: Any = mujoco.MjSpec.from_string(text)
        model = spec.compile()
        data = mujoco.MjData(model)
        time = np.arange(samples) * DT_S
        control = (15.0 - 10.0 * np.cos(2.0 * np.pi * time / 6.0))[:, None]
        start = sysid.create_initial_state(model, data.qpos, data.qvel, data.act)
        state, sensor = rollout.rollout(model, data, start, control[:-1])
        noise = np.random.default_rng(0).normal(0.0, 1e-5, sensor[0].shape)
        seen = sysid.TimeSeries.from_names(state[0][:, 0], sensor[0] + noise, model)
        controls = sysid.TimeSeries(time, control)
        self.sequences = sysid.ModelSequences("tendon", spec, "loops", start, controls, seen)

    def run(self) -> dict[str, float]:
        """Return the fitted parameters."""
        found = sysid.ParameterDict()
        for name, true in TRUE.items():
            found.add(sysid.Parameter(name, true, 0.1 * true, 3.0 * true, modifier=self._modifier(name)))
            found[name].value[:] = 0.6 * true
        residual = sysid.build_residual_fn(models_sequences=[self.sequences], n_threads=1)
        fitted, _ = sysid.optimize(found, residual, optimizer="mujoco", verbose=False)
        return {name: float(fitted[name].value[0]) for name in TRUE}

    def _modifier(self, name: str) -> Any:
        nodes = self.nodes

        def modify(spec: Any, parameter: Any) -> None:
            value = float(parameter.value[0])
            if name == "friction":
                for i in range(nodes):
                    spec.tendon("tendon" if nodes == 1 else f"f{i}").frictionloss = value / nodes
            elif name == "damping":
                for i in range(nodes):
                    _put(spec.joint("slide" if nodes == 1 else f"s{i}"), "damping", value)
            else:
                _put(spec.joint("slide" if nodes == 1 else f"s{nodes - 1}"), "stiffness", value)

        return modify


def _put(part: Any, field: str, value: float) -> None:
    old = getattr(part, field)
    # some releases hold the coefficients of a polynomial here
    setattr(part, field, value if np.ndim(old) == 0 else np.concatenate(([value], np.asarray(old)[1:])))
