"""Paired slopes by the generator of PAPER.md, written here anew: the tests do not lean on the package's own."""

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

GAIN = {"NP": 1.08, "CP": 1.0, "ND": 1.12}
PULLEY = {"NP": -0.01, "CP": 0.0, "ND": 0.03}
BETA = (-1.444, -1.043)


def slopes(place: str, count: int, rng: np.random.Generator, scatter: float = 1.0):
    """Return the slopes of both systems, each of shape (count, 2)."""
    u = ((np.arange(count) + 0.5) / count) ** 1.75
    z = (u - u.mean()) / u.std()
    e1, e2 = scatter * rng.standard_normal((2, count))
    n = scatter * rng.standard_normal((4, count))
    act = [-0.54 - 0.046 * z + 0.0035 * e1 + 0.0076 * n[0], 0.5228 + 0.0347 * z + 0.0035 * e1 + 0.003 * n[1]]
    sstl = [-1.3141 - 0.0875 * z + 0.0137 * e2 + 0.0129 * n[2], 1.1919 + 0.1034 * z + 0.0137 * e2 + 0.0232 * n[3]]
    pulley = np.array([-PULLEY[place], PULLEY[place]])
    return np.exp(np.array(sstl).T * GAIN[place] + pulley), np.exp(np.array(act).T * GAIN[place])


def rows(per_place: int = 50, seed: int = 0, scatter: float = 1.9, places=("NP", "CP", "ND")) -> list[dict]:
    """Return Theta rows: two a configuration."""
    rng = np.random.default_rng(seed)
    made = []
    for place in places:
        sstl, act = slopes(place, per_place, rng, scatter)
        for i in range(per_place):
            name = f"{place}-{i:03d}"
            for system, gamma, beta in (("sstl", sstl[i], (0.033, 4.366)), ("act", act[i], BETA)):
                made.append(
                    {
                        "run_id": f"{name}-{system}",
                        "config_id": name,
                        "system": system,
                        "location": place,
                        "lead_mm": 2.5 * i,
                        "gamma_p": gamma[0],
                        "gamma_r": gamma[1],
                        "beta_p": beta[0],
                        "beta_r": beta[1],
                        "loops": 3,
                        "status": "ok",
                    }
                )
    return made


def theta(made: list[dict]) -> pa.Table:
    kinds = {
        "run_id": pa.string(),
        "config_id": pa.string(),
        "system": pa.string(),
        "location": pa.string(),
        "lead_mm": pa.float64(),
        "gamma_p": pa.float64(),
        "gamma_r": pa.float64(),
        "beta_p": pa.float64(),
        "beta_r": pa.float64(),
        "loops": pa.int64(),
        "status": pa.string(),
    }
    missing = ["gamma_p_se", "beta_p_se", "gamma_r_se", "beta_r_se", "inlier_p", "inlier_r", "rmse_p_n", "rmse_r_n"]
    columns = {k: pa.array([r[k] for r in made], t) for k, t in kinds.items()}
    columns.update({k: pa.nulls(len(made), pa.float64()) for k in missing})
    if any("tendon" in r for r in made):
        columns["tendon"] = pa.array([r.get("tendon") for r in made], pa.string())
    return pa.table(columns)


def write(path: Path, made: list[dict]) -> Path:
    pq.write_table(theta(made), path)
    return path


def with_tendons(made: list[dict], shift: float) -> list[dict]:
    """Return the rows with the actuation side doubled: tendon B has other slopes than A."""
    done = []
    for row in made:
        if row["system"] == "sstl":
            done.append(row)
            continue
        done.append({**row, "run_id": row["run_id"] + "-A", "tendon": "A"})
        done.append(
            {
                **row,
                "run_id": row["run_id"] + "-B",
                "tendon": "B",
                "gamma_p": row["gamma_p"] * (1 - shift),
                "gamma_r": row["gamma_r"] * (1 + shift),
            }
        )
    return done
