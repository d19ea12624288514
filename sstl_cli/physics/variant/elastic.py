"""What stretches: segments of tendon with rope slip and creep, and the load with its joint."""

from __future__ import annotations

from math import exp, log1p

from numba import njit

from sstl_cli.physics.variant.line import Array, Line, Spring, Trial


@njit(cache=True)
def stretch(law: Spring, c: float, old: float, tension: float, rope: float, flow: float, give: float) -> tuple[float, float]:
    """Return how far a segment of compliance c stretches in a step from one tension to another (mm), and its slope.

    In the step it creeps by `give` x tension - `flow`; `rope` is the force between its wires before.
    """
    move, slope = c * (tension - old), c
    if law.plain:
        return move, slope
    if law.rope != 0.0:
        if law.rope_code == 0:
            a = 4.0 * law.rope_shape
            move += c * a * (exp(-old / 4.0) - exp(-tension / 4.0))
            slope += c * law.rope_shape * exp(-tension / 4.0)
        else:
            z = rope + tension - old
            move -= c * law.rope_shape * (min(max(z, -2.0), 2.0) - rope)
            slope -= c * law.rope_shape * (1.0 if abs(z) < 2.0 else 0.0)
    return move + give * tension - flow, slope + give


@njit(cache=True)
def load_stretch(law: Spring, old: float, tension: float, held: float, place: float) -> tuple[float, float]:
    """Return how far the load gives in a step (mm), and its slope; `held` and `place` are the state of its joint."""
    step = tension - old
    if law.plain:
        return step / law.load_k1, 1.0 / law.load_k1
    if law.fung > 0.0:
        b = law.fung / law.load_k1
        move = (log1p(b * tension) - log1p(b * old)) / law.fung
        slope = 1.0 / (law.load_k1 * (1.0 + b * tension))
    elif law.joint_share > 0.0:
        z = held + law.joint_share / (1.0 + law.joint_share) * step
        new = min(max(z, -law.joint_n), law.joint_n)
        move = (step - new + held) / law.load_k1
        slope = (1.0 if new != z else 1.0 / (1.0 + law.joint_share)) / law.load_k1
    else:
        move, slope = step / law.load_k1, 1.0 / law.load_k1
    if law.play > 0.0:
        new = place + step / law.play_n
        move += law.play * (min(max(new, 0.0), 1.0) - place)
        slope += law.play / law.play_n if 0.0 < new < 1.0 else 0.0
    return move, slope


@njit(cache=True)
def foresee_creep(line: Line, law: Spring, trial: Trial, dt: float) -> None:
    """Write how much every segment will creep in a step of dt: give x tension - flow (mm)."""
    for k in range(line.compliance.size):
        flow, give = 0.0, 0.0
        for i in range(line.creep_s.size):
            r = dt / (dt + line.creep_s[i])
            flow += r * line.crept[k, i]
            give += r * law.creep * line.creep_share[i] * line.compliance[k]
        trial.flow[k], trial.give[k] = flow, give


@njit(cache=True)
def settle(line: Line, law: Spring, dt: float, tension: Array) -> None:
    """Carry creep, rope and load over a step that ends at these tensions."""
    if law.plain:
        return
    last = line.compliance.size - 1
    for k in range(last + 1):
        step = tension[k] - line.tension[k]
        if law.rope != 0.0 and law.rope_code == 1:
            line.rope[k] = min(max(line.rope[k] + step, -2.0), 2.0)
        if law.creep != 0.0:
            for i in range(line.creep_s.size):
                goal = law.creep * line.creep_share[i] * line.compliance[k]
                line.crept[k, i] += dt / (dt + line.creep_s[i]) * (goal * tension[k] - line.crept[k, i])
    step = tension[last] - line.tension[last]
    if law.joint_share > 0.0:
        z = line.joint[0] + law.joint_share / (1.0 + law.joint_share) * step
        line.joint[0] = min(max(z, -law.joint_n), law.joint_n)
    if law.play > 0.0:
        line.joint[1] = min(max(line.joint[1] + step / law.play_n, 0.0), 1.0)
