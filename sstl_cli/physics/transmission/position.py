"""The proximal position that belongs to an input and an output tension: load, stretch, creep, play and slack."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sstl_cli.physics.effect import Drive, Law, Position
from sstl_cli.physics.filters import low_pass, play
from sstl_cli.physics.transmission.model import Active
from sstl_cli.physics.transmission.play import play_operator

Array = NDArray[np.float64]
ARC_STATIONS = 12
# below this tension a line hangs loose (N)
SLACK_N = 0.05
# stretch of the load spring over which the play of its joint is passed, as half-width (mm)
JOINT_MM = 2e-3
# Newton's rule doubles its digits: a step below this share leaves what rounding leaves
ROUNDING = 1e-9


def predict_position(drive: Drive, theta: float, active: Active, tension_out: Array, mean_n: Array | None = None) -> Array:
    """Return the proximal position (mm, shape (n,)) that belongs to an input and an output tension.

    The load spring moves with the output; an elastic tendon adds the stretch of the tension along the line,
    which depends on where the bend sits. The origin is arbitrary. Friction that depends on the local tension
    or changes with time counts by its nominal theta only, in the tension along the line (``mean_n``, where that is known).
    """
    mechanics = drive.mechanics
    position = Position(length_mm=mechanics.length_mm)
    for effect, values in active.of_hook("position"):
        effect.position(position, values)  # type: ignore[misc]
    x = _spring(tension_out, mechanics.end_n_per_mm(drive.system), position.cubic_per_mm2)
    if position.play_mm > 0.0:
        x = x + 0.5 * position.play_mm * (x - play(x, JOINT_MM)) / JOINT_MM
    if position.tendon_mm_per_n > 0.0 or position.creep_fraction > 0.0:
        mean = mean_tension(drive, theta, active, tension_out) if mean_n is None else mean_n
        if position.tendon_mm_per_n > 0.0:
            x = x + position.tendon_mm_per_n * mean
        if position.creep_fraction > 0.0:
            # creep is a share of the tendon as built where no other is given
            compliance = position.creep_fraction * (position.tendon_mm_per_n or mechanics.tendon_mm_per_n)
            # one where they are not spread
            times = {position.creep_s * position.creep_spread**k for k in (-1, 0, 1)}
            x = x + compliance * np.mean([low_pass(mean, drive.dt_s, tau) for tau in times], axis=0)
    if position.sheath_mm_per_n > 0.0:
        x = x + position.sheath_mm_per_n * drive.tension_n
    if position.gap_mm > 0.0:
        x = x - position.gap_mm * (drive.tension_n <= SLACK_N)
    return x


def mean_tension(drive: Drive, theta: float, active: Active, tension_out: Array) -> Array:
    """Return the tension (N) averaged over the length of a pass and summed over the passes.

    The tension at every station is a play of the input: Coulomb plays in a row are one play, whose line is
    the composition of theirs.
    """
    law = Law()
    for effect, values in active.of_hook("law"):
        effect.law(law, values)  # type: ignore[misc]
    theta = theta * drive.mechanics.friction(drive.system)
    before, behind = drive.mechanics.straight(drive.location)
    arc = 1.0 - before - behind
    bend = [(arc / ARC_STATIONS, theta / ARC_STATIONS)] * ARC_STATIONS
    passes = [[(before, 0.0), *bend, (behind, 0.0)]]
    if drive.system == "sstl":
        passes.append([(behind, 0.0), *bend, (before, 0.0)])
    total = np.zeros_like(drive.tension_n)
    pull, release = (1.0, -law.begin_n), (1.0, law.begin_n)
    start = float(tension_out[0])
    for number, stations in enumerate(passes):
        if number:
            pull = _after(pull, law.pulley_pull, law.pulley_n)
            release = _after(release, -law.pulley_release, -law.pulley_n)
        for share, angle in stations:
            # the tension in the middle of the station stands for all of it
            for half in (0, 1):
                pulled, released, spread = 0.5 * angle * law.scale_pull, 0.5 * angle * law.scale_release, 0.5 * share * law.constant_n
                pull = _after(pull, pulled, spread + pulled * law.adhesion_n)
                release = _after(release, -released, -(spread + released * law.adhesion_n))
                if half == 0:
                    total += share * np.maximum(play_operator(drive.tension_n, *pull, *release, start), 0.0)
    return total


def _after(line: tuple[float, float], angle: float, loss_n: float) -> tuple[float, float]:
    """Return slope and bias (N) of a propagation line continued through friction ``angle`` and a loss."""
    decay = float(np.exp(-angle))
    return line[0] * decay, line[1] * decay - loss_n


def _spring(tension: Array, k1: float, cubic: float) -> Array:
    """Return x of T = k1 (x + cubic x^3) by Newton's rule (monotone, converges from above)."""
    linear = tension / k1
    if cubic <= 0.0:
        return linear
    x = linear.copy()
    for _ in range(20):
        step = (x + cubic * x * x * x - linear) / (1.0 + 3.0 * cubic * x * x)
        x -= step
        if float(np.max(np.abs(step), initial=0.0)) < ROUNDING * float(np.max(np.abs(x), initial=0.0)):
            break
    return x
