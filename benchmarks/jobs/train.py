"""Table III: five variants, twenty seeds each."""

from __future__ import annotations

import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import torch
from sklearn.neural_network import MLPRegressor
from threadpoolctl import threadpool_limits

from benchmarks.harness import Row, faster, seconds
from benchmarks.peers import torch_loop
from sstl_cli.core.rng import stream
from sstl_cli.mapping.split import FIT, VALIDATION, make_splits
from sstl_cli.mapping.training import Fitted, Options, fit
from sstl_cli.mapping.variants import VARIANTS
from sstl_cli.physics.generator import generate


@contextmanager
def _one_thread() -> Iterator[None]:
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        with threadpool_limits(1):
            yield
    finally:
        torch.set_num_threads(before)


def _regressor(seed: int, batch: int, options: Options) -> MLPRegressor:
    """Return scikit-learn's network of the same size, trained alike."""
    return MLPRegressor(
        hidden_layer_sizes=(128,) * 5,
        activation="tanh",
        alpha=options.weight_decay,
        batch_size=batch,
        max_iter=options.epochs,
        learning_rate_init=options.learning_rate,
        early_stopping=True,
        n_iter_no_change=options.patience,
        tol=0.0,
        random_state=seed,
    )


def _row(name: str, job: str, peer: str, target: float, own: list[float], other: list[float], scaled: float, note: str) -> Row:
    return Row(name, job, peer, target, faster(own, other, scaled), seconds={"ours": min(own), "peer": min(other) * scaled}, note=note)


def _lowest(found: Fitted) -> list[tuple[int, float]]:
    """Return the seed and the least error of both slopes on the validation part of each network."""
    return [(c.seed, float(np.sqrt(c.val_loss.min() / 2))) for c in found.curves]


def run(quick: bool, folder: Path) -> list[Row]:
    """Compare with networks trained one after the other."""
    seeds, options, repeat = (2, Options(epochs=40), 1) if quick else (20, Options(), 2)
    peers = 1 if quick else 2
    cases = [c for c in generate("paper-150", stream(1, "configurations")) if c.sstl is not None and c.act is not None]
    x = np.array([[c.sstl.gamma_p, c.sstl.gamma_r] for c in cases])
    y = np.array([[c.act.gamma_p, c.act.gamma_r] for c in cases])
    ids = [c.id for c in cases]
    splits = make_splits({c.id: str(c.location) for c in cases}, range(seeds), 0)
    nets = [v for v in VARIANTS if v.alpha is not None]

    done: list[Fitted] = []

    def ours() -> None:
        done[:] = [fit(x, y, ids, splits, VARIANTS, options)]

    fitting, validating = (splits.mask(ids, part) for part in (FIT, VALIDATION))
    mean, scale = x.mean(0), x.std(0)
    tensors = [[torch.from_numpy(a[m[s]]).float() for m in (fitting, validating) for a in ((x - mean) / scale, y)] for s in range(peers)]
    epochs: list[int] = []
    theirs: list[float] = []
    how = torch_loop.How(options.epochs, options.patience, options.learning_rate, options.weight_decay)

    def loop() -> None:
        for v in nets:
            for s in range(peers):
                net, used = torch_loop.train(*tensors[s], float(v.alpha or 0.0), v.weight_inv, s, how)
                epochs.append(used)
                theirs.append(torch_loop.rmse(net, *tensors[s][1:]))

    def regressor() -> None:
        for s in range(peers):
            rows = fitting[s] | validating[s]
            net = _regressor(s, int(rows.sum()), options)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                net.fit((x[rows] - mean) / scale, (y[rows] - y.mean(0)) / y.std(0))

    fit(x, y, ids, splits, VARIANTS, Options(epochs=5))
    works = (ours, loop, regressor)
    # the peers' networks are so small that more threads slow them down; one each is what they do best with
    with _one_thread():
        taken = [[seconds(work) for work in works] for _ in range(repeat)]
        # by the clock our stacks take all cores, and what a user would write takes one
        clocked = [[seconds(work, time.perf_counter) for work in works] for _ in range(repeat)]
    (own, peer, sk), (own_s, peer_s, sk_s) = (map(list, zip(*times, strict=True)) for times in (taken, clocked))
    alike = np.median([e for s, e in _lowest(done[0]) if s < peers]), np.median(theirs)
    job = f"train Table III: {len(VARIANTS)} variants x {seeds} seeds"
    scaled = seeds / peers
    stopped = f"peer on {peers} seeds, scaled by {scaled:g}; it stopped after {np.mean(epochs):.0f} epochs on average"
    equal = f"median error of the slopes {alike[0]:.4f} here and {alike[1]:.4f} there (the same seeds, validation part)"
    loops, library = "the plain torch loop, one after the other", "scikit-learn MLPRegressor of the same size, one after the other"
    cores, part = ", by the clock on all cores", f"peer on {peers} networks, scaled"
    return [
        _row("train/torch", job, loops, 8.0, own, peer, scaled, f"{stopped}; {equal}"),
        _row("train/torch-clock", job, loops + cores, 8.0, own_s, peer_s, scaled, stopped),
        _row("train/sklearn", job, library, 3.0, own, sk, scaled * len(nets), part),
        _row("train/sklearn-clock", job, library + cores, 3.0, own_s, sk_s, scaled * len(nets), part),
    ]
