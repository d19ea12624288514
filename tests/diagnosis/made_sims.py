"""What shares, folds and blocks read of a simulator, with records of a few samples."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np


class _Labelled(SimpleNamespace):
    def __len__(self):
        return len(self.u) // self.factor


def sim(*records, configs=("a",)):
    """Return the labels of records, end to end; a record is (u, {label: value})."""
    made = []
    for i, (u, labels) in enumerate(records):
        known = {"run_id": f"r{i}", "system": "act", "config": 0, "trajectory": "", "dt_s": 0.1, "factor": 1, **labels}
        u = np.asarray(u, float)
        made.append(_Labelled(u=u, rate=np.gradient(u, known["dt_s"]), **known))
    counts = [len(r) for r in made]
    ends = np.cumsum(counts)
    problem = SimpleNamespace(records=made, configs=configs, systems=tuple(sorted({r.system for r in made})))
    return SimpleNamespace(
        problem=problem,
        y=np.zeros(int(ends[-1])),
        weight=np.ones(int(ends[-1])),
        run=np.repeat(np.arange(len(made)), counts),
        config=np.repeat([r.config for r in made], counts),
        slices=lambda: [slice(int(e) - n, int(e)) for e, n in zip(ends, counts, strict=True)],
    )
