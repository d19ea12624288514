"""Friction that begins higher or lower and settles over time."""

import numpy as np

from sstl_cli.physics.bristle.effect import Effect, Parts, Values
from sstl_cli.physics.given import Bounds


def _build(made: Parts, v: Values) -> None:
    # a drift given by the path of the input tension goes by the mean time it takes
    run = made.run
    per_unit = made.spec.load_k1_n_per_mm if run.drive == "position" else 1.0
    rate = per_unit * float(np.abs(np.diff(run.command)).sum()) / float(run.time_s[-1] - run.time_s[0])
    made.law = made.law._replace(drift=v["d_mu"], drift_s=v["path_n"] / max(rate, 1e-9))
    made.contact.level[made.sheathed] += v["d_mu"]


EFFECT = Effect({"d_mu": Bounds(0.0, -0.3, 0.3), "path_n": Bounds(200.0, 10.0, 5000.0)}, build=_build)
