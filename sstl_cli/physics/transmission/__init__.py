"""The fast model: the play operator with friction-law, transition and instrument stages."""

from sstl_cli.physics.transmission.model import Active, activate, measure, predict
from sstl_cli.physics.transmission.play import play_operator
from sstl_cli.physics.transmission.position import mean_tension, predict_position

__all__ = ["Active", "activate", "mean_tension", "measure", "play_operator", "predict", "predict_position"]
