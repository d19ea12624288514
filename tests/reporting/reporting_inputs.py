"""Small synthetic outputs of the toolchain, made here from the play operator and plain formulas."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import numpy as np
import pyarrow as pa

from sstl_cli.core.parquet import write_table
from sstl_cli.core.provenance import Provenance
from sstl_cli.core.tables import COMMAND, EVALUATION, LOG, PARAMETERS, PHASES, SCORE, THETA, Column, Schema

MADE = Provenance("made by a test", seed=1)
HOSTILE = "<script>alert(1)</script>"
FORMULA = "=HYPERLINK(1)"
GAMMA = {"act": (0.59, 1.67), "sstl": (0.30, 3.05)}
HISTORY = Schema(
    "sstl.history",
    1,
    tuple(
        Column(n, t)
        for n, t in (
            ("variant", pa.string()),
            ("seed", pa.int64()),
            ("epoch", pa.int64()),
            ("train_loss", pa.float64()),
            ("val_loss", pa.float64()),
        )
    ),
)


def play(x, low, high, start):
    out = np.empty_like(x)
    last = start
    for k, value in enumerate(x):
        last = min(max(last, low * value), high * value)
        out[k] = last
    return out


def one_run(system, scale=1.0, n=1500):
    t = np.arange(n) * 0.02
    x = 14 + 9 * np.sin(2 * np.pi * t / 10 - np.pi / 2) * scale
    y = play(x, *GAMMA[system], GAMMA[system][0] * x[0])
    rising = np.gradient(x) >= 0
    on_low, on_high = np.isclose(y, GAMMA[system][0] * x), np.isclose(y, GAMMA[system][1] * x)
    phase = np.where(rising, np.where(on_low, "PP", "PB"), np.where(on_high, "RP", "RB"))
    return t, x, y, phase


def runs(count):
    names = [HOSTILE, FORMULA, "_hidden $x$"]
    for i in range(count):
        yield names[i] if i < len(names) else f"run-{i:03d}", "act" if i % 2 == 0 else "sstl", f"CP-{i // 2:03d}", i


def write_log(folder: Path, count=4, n=1500):
    logs, phases = [], []
    for name, system, config, i in runs(count):
        t, x, y, phase = one_run(system, 1 - 0.004 * i, n)
        noise = np.random.default_rng(i).normal(0, 0.03, n)
        same = {"run_id": [name] * n, "time_s": t}
        logs.append(
            pa.table(
                {
                    **same,
                    "config_id": [config] * n,
                    "system": [system] * n,
                    "location": ["CP"] * n,
                    "lead_mm": np.full(n, 2.0 * (i // 2)),
                    "trajectory": ["sine"] * n,
                    "tension_in_n": x,
                    "tension_out_n": y + noise,
                    "position_in_mm": pa.nulls(n, pa.float64()),
                    "tension_ref_n": pa.nulls(n, pa.float64()),
                }
            )
        )
        phases.append(pa.table({**same, "phase": phase}))
    write_table(folder / "log.parquet", pa.concat_tables(logs), LOG, MADE)
    write_table(folder / "phases.parquet", pa.concat_tables(phases), PHASES, MADE)
    return [folder / "log.parquet", folder / "phases.parquet"]


def write_theta(folder: Path, count=4, locations=("CP",)):
    rng = np.random.default_rng(5)
    rows = []
    for location in locations:
        for name, system, config, i in runs(count):
            p, r = GAMMA[system]
            row = {
                "run_id": f"{location}-{name}" if location != "CP" else name,
                "config_id": f"{location}-{config}",
                "system": system,
                "location": location,
                "lead_mm": 2.0 * (i // 2),
                "gamma_p": p * np.exp(rng.normal(0, 0.02) - 0.004 * i),
                "beta_p": rng.normal(-0.3, 0.1),
                "gamma_r": r * np.exp(rng.normal(0, 0.02) + 0.004 * i),
                "beta_r": rng.normal(0.4, 0.2),
                "inlier_p": 0.97,
                "inlier_r": 0.96,
                "rmse_p_n": 0.03,
                "rmse_r_n": 0.05,
                "loops": 3,
                "status": "ok",
            }
            rows.append({**row, **{q + "_se": 0.004 if "gamma" in q else 0.06 for q in PARAMETERS}})
    if rows:
        rows[-1].update(gamma_r=None, gamma_r_se=None, status="too few samples in release")
    write_table(folder / "theta.parquet", pa.Table.from_pylist(rows, schema=THETA.arrow()), THETA, MADE)
    return [folder / "theta.parquet"]


def write_compensation(folder: Path):
    t = np.arange(2500) * 0.01
    reference = 10 + 5 * np.sin(2 * np.pi * t / 10)
    phase = np.where(np.cos(2 * np.pi * t / 10) > 0, np.where(t % 10 < 0.6, "PB", "PP"), np.where(t % 10 < 3.2, "RB", "RP"))
    pieces, scores = [], []
    for method, size in (("none", 4.0), ("no-bias", 1.5), ("proposed", 0.5), ("DI", 0.3)):
        error = size * np.where(np.char.endswith(phase.astype(str), "B"), 1.5, 1.0) * np.cos(2 * np.pi * t / 10)
        n = len(t)
        pieces.append(
            pa.table(
                {
                    "run_id": ["CP-000 sine"] * n,
                    "config_id": ["CP-000"] * n,
                    "location": ["CP"] * n,
                    "trajectory": ["sine"] * n,
                    "method": [method] * n,
                    "time_s": t,
                    "tension_ref_n": reference,
                    "tension_cmd_n": reference * 2,
                    "tension_in_n": reference * 2,
                    "tension_out_n": reference + error,
                    "phase": phase,
                }
            )
        )
        scores.append(
            {
                "run_id": "CP-000 sine",
                "config_id": "CP-000",
                "location": "CP",
                "trajectory": "sine",
                "method": method,
                "window": "all",
                "rmse_n": float(np.sqrt(np.mean(error**2))),
                "std_n": float(error.std()),
                "mape_pct": 10 * size,
                "mape_floor_n": 1.0,
                "masked_pct": 0.0,
                "reduction_pct": 100 * (1 - size / 4),
            }
        )
    write_table(folder / "commands.parquet", pa.concat_tables(pieces), COMMAND, MADE)
    write_table(folder / "scores.parquet", pa.Table.from_pylist(scores, schema=SCORE.arrow()), SCORE, MADE)
    return [folder / "commands.parquet", folder / "scores.parquet"]


def write_mapping(folder: Path):
    rng = np.random.default_rng(8)
    history, evaluation = [], []
    for variant, level in (("full", 0.02), ("w/o pairing", 0.05)):
        for seed in range(3):
            history += [
                {
                    "variant": variant,
                    "seed": seed,
                    "epoch": e,
                    "train_loss": level + np.exp(-e / 8) * (1 + 0.1 * seed),
                    "val_loss": 1.3 * level + np.exp(-e / 9),
                }
                for e in range(40)
            ]
            p, r = level * (1 + 0.1 * seed), 2 * level * (1 - 0.1 * seed)
            evaluation.append(
                {
                    "variant": variant,
                    "seed": seed,
                    "rmse_gamma_p": p,
                    "rmse_gamma_r": r,
                    "rmse_total": float(np.hypot(p, r)),
                    "outside_range_pct": 2.5,
                }
            )
    write_table(folder / "history.parquet", pa.Table.from_pylist(history, schema=HISTORY.arrow()), HISTORY, MADE)
    write_table(folder / "evaluation.parquet", pa.Table.from_pylist(evaluation, schema=EVALUATION.arrow()), EVALUATION, MADE)
    return [folder / "history.parquet", folder / "evaluation.parquet", write_predictions(folder, rng), write_model(folder)]


def write_predictions(folder: Path, rng):
    rows = []
    for i in range(40):
        row = {"run_id": f"r{i}", "config_id": f"C{i:02d}", "location": ("NP", "CP", "ND")[i % 3], "lead_mm": float(i)}
        for name, middle, noise in (("gamma_p", 0.58, 0.01), ("gamma_r", 1.7, 0.03)):
            true = middle * np.exp(rng.normal(0, 0.05))
            row.update({f"{name}_true": true, f"{name}_pred": true + rng.normal(0, noise)})
        rows.append(row)
    schema = Schema("sstl.predictions", 1, tuple(Column(n, pa.string() if isinstance(rows[0][n], str) else pa.float64()) for n in rows[0]))
    write_table(folder / "predictions.parquet", pa.Table.from_pylist(rows, schema=schema.arrow()), schema, MADE)
    return folder / "predictions.parquet"


def write_model(folder: Path):
    header = {"__metadata__": {"variant": "full", "seed": "1"}, "net.0.weight": {"dtype": "F32", "shape": [8, 2], "data_offsets": [0, 64]}}
    raw = json.dumps(header).encode()
    (folder / "model.safetensors").write_bytes(struct.pack("<Q", len(raw)) + raw + bytes(64))
    return folder / "model.safetensors"


def where():
    weights = {
        ("act", "PB"): 1.0,
        ("act", "PP"): 2.0,
        ("act", "RB"): 1.0,
        ("act", "RP"): 2.0,
        ("sstl", "PB"): 5.0,
        ("sstl", "PP"): 20.0,
        ("sstl", "RB"): 6.0,
        ("sstl", "RP"): 25.0,
    }
    cells = [(s, p, f"CP-{c:03d}", w * (1 + 0.2 * c)) for (s, p), w in weights.items() for c in range(5)]
    total = sum(w for *_, w in cells)
    return [{"system": s, "phase": p, "config_id": c, "share_pct": 100 * w / total, "rmse_n": 0.1 * w} for s, p, c, w in cells]


def loop():
    _, x, y, _ = one_run("sstl", n=600)
    return {
        "run_id": HOSTILE,
        "system": "sstl",
        "tension_in_n": x.tolist(),
        "measured_n": y.tolist(),
        "base_n": (0.9 * y).tolist(),
        "with_effect_n": (y + 0.05).tolist(),
    }


def diagnosis(effects=("pulley_friction",), status="identified"):
    ids = ["pulley_friction", "zero_offset", "gain_error", "const_friction", "viscous"]
    cosine = [[1.0 if i == j else round(0.99 - 0.12 * abs(i - j), 3) for j in range(5)] for i in range(5)]
    share = (0.94, 0.03, 0.015, 0.01, 0.005)
    return {
        "schema": "sstl.diagnosis/1",
        "verdict": {
            "status": status,
            "effects": list(effects),
            "confidence": 0.94,
            "ambiguity_group": list(effects),
            "why": "The sstl channel loses tension at the pulley in both directions, the act channel does not.",
        },
        "gap": {
            "rmse_base_n": 0.61,
            "rmse_retuned_n": 0.44,
            "rmse_with_effect_n": 0.041,
            "noise_floor_n": 0.028,
            "shrink_pct": 90.7,
            "shrink_ci95_pct": [89.9, 91.4],
            "explained_of_reducible_pct": 96.8,
            "held_out": True,
        },
        "where": where(),
        "candidates": [
            {
                "id": i,
                "probability": q,
                "rmse_held_out_n": 0.041 + 0.08 * k,
                "shrink_pct": 90.7 - 18 * k,
                "parameters": [{"name": "m", "unit": "1", "estimate": 0.12, "ci95": [0.11, 0.13], "at_bound": k == 4}],
                "identifiability": "identifiable" if k < 3 else "not_identifiable",
            }
            for k, (i, q) in enumerate(zip(ids, share, strict=True))
        ],
        "loops": [loop(), {**loop(), "run_id": "run-003"}],
        "isolability": {"ids": ids, "cosine": cosine},
        "next_experiment": {
            "separates": ["pulley_friction", "zero_offset"],
            "trajectory": "slow triangle, 3 to 30 N, two amplitudes",
            "why": "The pulley scales with tension, an offset does not.",
        },
    }


def blind():
    labels = ["none", "pulley_friction", "zero_offset", "viscous", "unknown"]
    matrix = [[19, 0, 0, 0, 1], [0, 18, 1, 0, 1], [0, 1, 17, 0, 2], [1, 0, 0, 18, 1], [0, 1, 0, 0, 19]]
    strength = [
        {
            "strength": s,
            "isolation": {"k": k, "n": 20, "low": lo, "high": hi},
            "false_alarm": {"k": 1, "n": 20, "low": 0.0, "high": 0.2},
            "wrong_commits": {"k": w, "n": 20, "low": 0.0, "high": 0.3},
        }
        for s, k, lo, hi, w in ((0.4, 15, 0.53, 0.89, 2), (1.2, 18, 0.7, 0.97, 1), (4.0, 20, 0.84, 1.0, 0))
    ]
    return {
        "schema": "sstl.blind.score/1",
        "cases": 100,
        "confusion": {"labels": labels, "matrix": matrix},
        "by_strength": strength,
        "reliability": [
            {"p_low": 0.1 * i, "p_high": 0.1 * i + 0.1, "mean_p": 0.1 * i + 0.05, "share_right": min(1, 0.1 * i + 0.08), "n": 4 + i}
            for i in range(10)
        ],
        "ece": 0.041,
        "baselines": [
            {"name": "sstl diagnose", "isolation": 0.92, "false_alarm": 0.04, "wrong_commits": 0.03},
            {"name": "always none", "isolation": 0.0, "false_alarm": 0.0, "wrong_commits": 0.0},
            {"name": "smallest RMSE", "isolation": 0.63, "false_alarm": 1.0, "wrong_commits": 0.37},
        ],
        "by_d2": [{"d2_median": 5.0, "isolation": 0.2, "in_group": 0.9}, {"d2_median": 400.0, "isolation": 0.9, "in_group": 1.0}],
        "shrink": [{"predicted_pct": 10.0 * i, "realised_pct": 10.0 * i - 2} for i in range(3, 10)],
        "targets": [
            {"name": "false alarm", "value": 0.04, "target": 0.05, "met": True},
            {"name": "isolation 0.1-0.6", "value": 0.75, "target": 0.8, "met": False},
        ],
    }


def write_documents(folder: Path):
    (folder / "diagnosis.json").write_text(json.dumps(diagnosis()))
    (folder / "blind.json").write_text(json.dumps(blind()))
    (folder / "check.json").write_text(json.dumps({"schema": "sstl.check/1", "runs": 4, "usable": True, "remarks": {"note": HOSTILE}}))
    return [folder / n for n in ("diagnosis.json", "blind.json", "check.json")]


def write_all(folder: Path, count=4):
    return [
        *write_log(folder, count),
        *write_theta(folder, count),
        *write_compensation(folder),
        *write_mapping(folder),
        *write_documents(folder),
    ]
