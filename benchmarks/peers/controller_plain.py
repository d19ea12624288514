"""Algorithm 1 in plain Python: a class with a ``step``, as one would write it for a rig, with the same duties."""

from __future__ import annotations

from math import isfinite


class Controller:
    """Feedforward compensation with the doubled correction in backlash, Eqs. (ff_cmd) to (bl_cmd2).

    Like the product's it holds and ramps down when an input is lost or out of range, returns at the ramp's rate, and
    reports the phase.
    """

    def __init__(
        self,
        gamma_p: float,
        beta_p: float,
        gamma_r: float,
        beta_r: float,
        t_max: float = 80.0,
        tolerance: float = 1.0,
        hold: int = 50,
        ramp: float = 0.02,
    ) -> None:
        self.pull, self.release = (gamma_p, beta_p), (gamma_r, beta_r)
        self.t_max, self.tolerance, self.hold, self.ramp = t_max, tolerance, hold, ramp
        self.extreme: float | None = None
        self.direction = 0
        self.backlash = False
        self.held = self.threshold = self.command = 0.0
        self.lost = 0
        self.returning = self.awake = False

    def step(self, t_ref: float, t_in: float) -> tuple[float, str]:
        """Return the commanded input tension (N) and the phase."""
        if not (isfinite(t_ref) and isfinite(t_in)) or not (
            -self.tolerance <= t_ref <= self.t_max + self.tolerance and -self.tolerance <= t_in <= 1.25 * self.t_max + self.tolerance
        ):
            return self.safe(), "SAFE"
        self.lost = 0
        if not self.awake:
            self.awake = True
            self.command = min(max(t_in, 0.0), self.t_max)
        turned = self.turn(t_ref)
        gamma, beta = self.release if self.direction < 0 else self.pull
        if turned:
            if not self.backlash:
                before_gamma, before_beta = self.pull if self.direction < 0 else self.release
                self.held = before_gamma * t_in + before_beta
                self.backlash = True
            self.threshold = (self.held - beta) / gamma
        if self.backlash:
            reached = t_in <= self.threshold if self.direction < 0 else t_in >= self.threshold
            if reached:
                self.backlash = False
        target = 2.0 * t_ref - self.held if self.backlash else t_ref
        command = min(max((target - beta) / gamma, 0.0), self.t_max)
        if self.returning:
            if abs(command - self.command) <= self.ramp:
                self.returning = False
            else:
                command = min(max(command, self.command - self.ramp), self.command + self.ramp)
        self.command = command
        return command, ("R" if self.direction < 0 else "P") + ("B" if self.backlash else "P")

    def turn(self, t_ref: float) -> bool:
        """Follow the direction of the reference; True at a reversal."""
        before = self.direction
        if self.extreme is None:
            self.extreme = t_ref
            return False
        if t_ref > self.extreme:
            self.direction = 1
        elif t_ref < self.extreme:
            self.direction = -1
        if self.direction != before:
            self.extreme = t_ref
        elif before > 0:
            self.extreme = max(self.extreme, t_ref)
        elif before < 0:
            self.extreme = min(self.extreme, t_ref)
        return before != 0 and self.direction != before

    def safe(self) -> float:
        """Hold the last command, then ramp down."""
        self.lost += 1
        if self.lost > self.hold:
            self.command = max(self.command - self.ramp, 0.0)
            self.extreme, self.direction, self.backlash = None, 0, False
        self.returning = self.awake
        return self.command


def replay(theta: tuple[float, float, float, float], t_ref: list[float], t_in: list[float]) -> tuple[list[float], list[str]]:
    """Return commands (N) and phases for a recorded input tension."""
    controller = Controller(*theta)
    commands, phases = [], []
    for a, b in zip(t_ref, t_in, strict=True):
        command, phase = controller.step(a, b)
        commands.append(command)
        phases.append(phase)
    return commands, phases
