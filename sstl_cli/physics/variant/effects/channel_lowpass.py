"""An output channel behind a filter of second order or a sliding mean."""

from sstl_cli.physics.variant.effect import Effect, Reading, Values, wide
from sstl_cli.physics.variant.filters import second_order, sliding_mean
from sstl_cli.physics.variant.laws import Chosen, Law

BUTTERWORTH = 0.5**0.5
LAWS = (
    Law("butterworth", "second order, same delay at low frequency", "Butterworth 1930"),
    Law("moving_average", "mean over the last 2 tau", "sigma-delta converters: sinc filter"),
)


def _sense(seen: Reading, v: Values, law: Chosen) -> None:
    tau = v[f"tau_{seen.system}_s"]
    if tau > 0.0 and law.id == "butterworth":
        seen.t_out = second_order(seen.time, seen.t_out, tau, BUTTERWORTH, 0.0)
    elif tau > 0.0:
        seen.t_out = sliding_mean(seen.time, seen.t_out, 2.0 * tau)


EFFECT = Effect({f"tau_{system}_s": wide(0.0, 0.0, 0.32) for system in ("act", "sstl")}, LAWS, order=70, sense=_sense)
