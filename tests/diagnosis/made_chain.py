"""The latent input by dense linear algebra: the precision of all states of the smoother at once."""

from __future__ import annotations

import numpy as np

from sstl_cli.diagnosis.smoother import DIFFUSE, STATES, Reading

MOVE = np.array([[1.0, 1.0, 0.5], [0.0, 1.0, 1.0], [0.0, 0.0, 1.0]])


def posterior(known, noise: Reading, corners, bends, y=None, rest=None):
    """Return mean of the values, (n,), and their covariance given all readings, (n, n)."""
    mean, whole, m = states(known, noise, corners, bends, y, rest)
    return mean[::m], whole[::m, ::m]


def states(known, noise: Reading, corners, bends, y=None, rest=None):
    """Return mean of all states, end to end, their covariance, and how many there are at an instant."""
    # without slow noise there is no such state
    n, m = len(known), 4 if noise.slow else 3
    steps, weights, move = np.eye(m * n), np.zeros((m * n, m * n)), np.eye(m) * noise.memory
    move[:3, :3] = MOVE
    for k in range(n):
        here = slice(m * k, m * k + m)
        c, b = corners[k], bends[k]
        fresh = np.eye(m) * noise.slow * (1.0 - noise.memory**2 if k else 1.0)
        fresh[:3, :3] = (
            np.array([[5.0 * c / 12.0, c / 2.0, 0.0], [c / 2.0, c, 0.0], [0.0, 0.0, b]]) if k else np.eye(3) * DIFFUSE * noise.white
        )
        weights[here, here] = np.linalg.inv(fresh)
        if k:
            steps[here, m * k - m : m * k] = -move
    reading = np.eye(m)[0] + (np.eye(m)[3] if noise.slow else 0.0)
    seen = np.kron(np.diag(known / noise.white), np.outer(reading, reading))
    # where it rests the increment was read, as 0
    still = np.kron(np.diag(np.zeros(n) if rest is None else rest * DIFFUSE / noise.white), np.outer(np.eye(m)[1], np.eye(m)[1]))
    whole = np.linalg.inv(steps.T @ weights @ steps + seen + still)
    mean = whole @ np.kron(known * y / noise.white, reading) if y is not None else np.zeros(m * n)
    return mean, whole, m


def pairs(v):
    """Return the covariance of a state from its pairs."""
    out = np.zeros((STATES, STATES))
    out[np.triu_indices(STATES)] = v
    return out + np.triu(out, 1).T
