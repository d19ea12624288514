"""Truths made by hand: a plain bench, and what a test asks of it."""

from sstl_cli.blind.truth import CaseTruth


def made_truth(effects=(), **told):
    """Return the truth of a case in which the effects were withheld."""
    plain = {
        "kind": ("none", "single", "pair")[min(len(effects), 2)], "effects": {e: {} for e in effects}, "strength_target": 1.2,
        "strength": 1.2 if effects else 0.0, "band": 1.2, "channel": "out", "gap_n": 0.1, "gap_null_n": 0.0, "noise_n": 0.05,
        "excluded": False, "unlisted": (), "wrong_nominal": False, "poor": None, "theta": (1.0,), "theta_retuned": (1.0,),
        "nominal": (1.0,), "seed": 1, "rate_hz": 100.0, "noise": {"white_n": 0.05}, "nodes": 40,
    }  # fmt: skip
    return CaseTruth(**{**plain, **told})
