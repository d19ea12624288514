"""Is the likelihood right? Residuals, ratios and chance gains on recordings whose truth is known.

Usage: python tools/likelihood.py [--cases 7] [--seed 515] [--work build/likelihood] [--out docs/likelihood.md]

Every recording is kept in the work folder as soon as it is judged: what was stopped goes on where it was. A change of the
program begins anew.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import likelihood_cases as lc
import numpy as np
from likelihood_targets import Measured, targets
from numpy.typing import NDArray
from page_part import commit
from scipy.stats import chi2

from sstl_cli.core.files import atomic
from sstl_cli.diagnosis.where import PHASES
from sstl_cli.physics.effects import catalogue

Array = NDArray[np.float64]
ROOT = Path(__file__).resolve().parents[1]
REFITTED = ("viscous", "stribeck", "channel_lowpass")
TRUE = {
    "gain_error": {"g_act": 1.001, "g_sstl": 0.999},
    "const_friction": {"w_l_n": 0.02},
    "viscous": {"c_l_n_s_per_mm": 0.005},
    "channel_delay": {"tau_act_s": 0.002, "tau_sstl_s": 0.002},
}
DRAWS, DENSE = 24, 10
SIGNIFICANT = 0.95
# fewer samples than this say little of a chi^2
LEAST = 50


class Kept:
    """Results by name in a folder that belongs to one state of the program."""

    def __init__(self, folder: Path) -> None:
        digest = hashlib.sha256()
        for path in sorted([*(ROOT / "sstl_cli").rglob("*.py"), Path(lc.__file__)]):
            digest.update(path.read_bytes())
        self.folder = folder / digest.hexdigest()[:12]
        self.folder.mkdir(parents=True, exist_ok=True)

    def __call__(self, name: str, make: Callable[[], Any]) -> Any:
        """Return a result, made if it is not there."""
        path = self.folder / f"{name}.json"
        if not path.exists():
            begin = time.process_time()
            text = json.dumps({"found": make(), "cpu_s": time.process_time() - begin})
            with atomic(path, force=True) as out:
                out.write_text(text, encoding="utf-8")
        return json.loads(path.read_text(encoding="utf-8"))["found"]

    def cpu_s(self) -> float:
        """Return the processor time (s) of all results."""
        return sum(json.loads(p.read_text(encoding="utf-8"))["cpu_s"] for p in self.folder.glob("*.json"))


def null(simulator: int, setting: int, k: int, seed: int) -> dict[str, Any]:
    """Return what the likelihood says of one recording in which nothing is missing; and what effects gain by chance."""
    rate = lc.RATES_HZ[(k + setting + simulator) % len(lc.RATES_HZ)]
    made = lc.source(lc.SIMULATORS[simulator], rate, lc.SETTINGS[setting], seed + 100 * k + 10 * setting + simulator)
    heard = lc.heard(made, {})
    found: dict[str, Any] = {"rate": rate, **lc.whiteness(heard)}
    found["chance"] = {i: lc.chance(heard, i) for i in catalogue() if lc.shown(i)}
    if k == 0:
        found["refitted"] = {i: lc.refitted(heard, i) for i in REFITTED}
    return found


def _range(x: Array, digits: int = 3) -> str:
    low, middle, high = np.quantile(x, [0.05, 0.5, 0.95])
    return f"{middle:.{digits}f} ({low:.2f}-{high:.2f})"


def chi_squared(rows: dict[str, list[dict[str, Any]]], first: bool, head: str) -> list[str]:
    """Return the table of chi^2 per sample by phase: median over recordings, 90 % range, and all samples pooled."""
    at = slice(4, 8) if first else slice(0, 4)
    lines = [f"| {head} | recordings | " + " | ".join(f"{p}" for p in PHASES) + " | pooled | samples, least phase |", "|---" * 8 + "|"]
    for name, found in rows.items():
        square, count = (np.array([f[key][at] for f in found]) for key in ("square", "count"))
        cells = [_range((square / np.maximum(count, 1))[count[:, j] > LEAST, j]) for j in range(4)]
        pooled = " / ".join(f"{v:.3f}" for v in square.sum(axis=0) / count.sum(axis=0))
        lines.append(f"| {name} | {len(found)} | " + " | ".join(cells) + f" | {pooled} | {int(count.sum(axis=0).min())} |")
    return lines


def medians(rows: dict[str, list[dict[str, Any]]], first: bool) -> dict[str, float]:
    """Return the median chi^2 per sample over the recordings of each row, phase by phase; as the table has it."""
    at, found = slice(4, 8) if first else slice(0, 4), {}
    for name, recordings in rows.items():
        square, count = (np.array([f[key][at] for f in recordings]) for key in ("square", "count"))
        for j, phase in enumerate(PHASES):
            ratio = square[:, j] / np.maximum(count[:, j], 1)
            found[f"{name}, {phase}{', first half second' if first else ''}"] = float(np.median(ratio[count[:, j] > LEAST]))
    return found


def least_samples(rows: dict[str, list[dict[str, Any]]]) -> int:
    """Return the samples of the row and phase that have the fewest."""
    return min(int(np.sum([f["count"][:4] for f in recordings], axis=0).min()) for recordings in rows.values())


def hold_means(found: list[dict[str, Any]]) -> dict[str, tuple[float, float, int]]:
    """Return mean, standard error (mN) and number of the holds at 500 Hz, after pull and release.

    Holds of one recording share theta and the errors of its slow noise: recordings are independent, holds are not.
    """
    means = {}
    for j, name in enumerate(("pull", "release")):
        n, total, _ = np.array([f["holds"][j] for f in found if f["rate"] == 500.0 and f["holds"][j][0]]).T
        mean, many = float(total.sum() / n.sum()), len(n)
        spread = float(np.sqrt(np.sum((total - n * mean) ** 2) * many / (many - 1.0)) / n.sum())
        means[name] = (1e3 * mean, 1e3 * spread, int(n.sum()))
    return means


def held(means: dict[str, tuple[float, float, int]]) -> list[str]:
    """Return the mean over holds of what is left in them at 500 Hz, with its standard error (mN)."""
    cells = [f"{name}: {mean:+.2f} +- {spread:.2f} mN over {n} holds" for name, (mean, spread, n) in means.items()]
    return [
        "Means of holds of half a second or more, recorded at 500 Hz (errors between recordings), after the "
        + "; after the ".join(cells)
        + "."
    ]


def chance_gains(found: list[dict[str, Any]]) -> dict[str, tuple[int, float, int]]:
    """Return of every candidate the recordings, its mean gain over that of theory, and how often it is beyond the 95 % point."""
    gained = {}
    for effect_id in sorted({i for f in found for i in f["chance"]}):
        seen = [f["chance"][effect_id] for f in found if f["chance"][effect_id]]
        if seen:
            k, g = np.array(seen).T
            gained[effect_id] = (len(seen), float(g.sum() / k.sum()), int(np.sum(g > chi2.ppf(SIGNIFICANT, k))))
    return gained


def gains(gained: dict[str, tuple[int, float, int]]) -> list[str]:
    """Return the table of what every candidate gains by chance."""
    lines = ["| candidate | recordings | mean of 2 gain / strengths | beyond the 95 % point |", "|---" * 4 + "|"]
    return lines + [f"| {i} | {n} | {mean:.2f} | {beyond} ({100.0 * beyond / n:.0f} %) |" for i, (n, mean, beyond) in gained.items()]


def true_ratios(kept: Kept, seed: int) -> dict[str, tuple[int, float | None, tuple[float, float, float]]]:
    """Return of each true effect, and of all, the draws, the mean of twice the log ratio, and its variance over theory with the 90 % range."""
    found: dict[str, tuple[int, float | None, tuple[float, float, float]]] = {}
    total: list[Array] = []
    for effect_id, values in TRUE.items():
        k, *drawn = kept(f"ratio-{effect_id}", partial(lc.ratio, effect_id, values, DRAWS, seed))
        x = np.array(drawn)
        theory = 2.0 * k + 4.0 * max(float(x.mean()) - k, 0.0)
        total.append((x - x.mean()) ** 2 / theory * len(x) / (len(x) - 1))
        found[effect_id] = (len(x), float(x.mean()), _spread(total[-1].mean(), len(x) - 1))
    every = np.concatenate(total)
    found["all"] = (len(every), None, _spread(every.mean(), sum(len(t) - 1 for t in total)))
    return found


def ratios(found: dict[str, tuple[int, float | None, tuple[float, float, float]]]) -> list[str]:
    """Return the table of log-likelihood ratios of true models."""
    lines = ["| effect | draws | mean of 2 log ratio | variance over theory (90 % range) |", "|---" * 4 + "|"]
    for name, (n, mean, (value, low, high)) in found.items():
        lines.append(f"| {name} | {n} | {'' if mean is None else f'{mean:.0f} '}| {value:.2f} ({low:.2f}-{high:.2f}) |")
    return lines


def _spread(value: float, n: int) -> tuple[float, float, float]:
    low, high = value * n / chi2.ppf([0.95, 0.05], n)
    return float(value), float(low), float(high)


def dense_kept(kept: Kept, seed: int) -> list[tuple[str, Array]]:
    """Return what the estimated filter keeps of D^2, response by response, of each case with its name."""
    found = []
    for k in range(DENSE):
        name, s = lc.SIMULATORS[k % len(lc.SIMULATORS)], lc.SETTINGS[k % len(lc.SETTINGS)]
        x = np.array(kept(f"dense-{k}", partial(lc.kept, name, s, seed + k)))
        found.append((f"{name} | {1e3 * s[0]:.0f}, {1e3 * s[1]:.0f}, {s[2]:g}", x))
    return found


def dense(found: list[tuple[str, Array]]) -> list[str]:
    """Return the table of what the estimated filter keeps of D^2."""
    rows = ["| simulator | white, coloured (mN), correlation (s) | least response | median | greatest |", "|---" * 5 + "|"]
    return rows + [f"| {name} | {x.min():.3f} | {np.median(x):.3f} | {x.max():.3f} |" for name, x in found]


def page(kept: Kept, cases: int, seed: int) -> list[str]:
    """Return the lines of the page."""
    by_simulator: dict[str, list[dict[str, Any]]] = {}
    by_setting: dict[str, list[dict[str, Any]]] = {}
    for i, simulator in enumerate(lc.SIMULATORS):
        for j, s in enumerate(lc.SETTINGS):
            for k in range(cases):
                row = kept(f"null-{i}-{j}-{k}-{seed}", partial(null, i, j, k, seed))
                by_simulator.setdefault(simulator, []).append(row)
                name = f"{1e3 * s[0]:.0f}" + (f", {1e3 * s[1]:.0f} ({s[2]:g} s)" if s[1] else "")
                by_setting.setdefault(name, []).append(row)
    found = [row for rows in by_simulator.values() for row in rows]
    lag = np.array([f["neighbours"] for f in found])
    again = {i: np.array([f["refitted"][i] for f in found if "refitted" in f]) for i in REFITTED}
    refits = "; ".join(f"{i}: median {np.median(x):.1f}, largest {x.max():.1f}" for i, x in again.items())
    means, gained, drawn, filtered = hold_means(found), chance_gains(found), true_ratios(kept, seed), dense_kept(kept, seed)
    measured = Measured(
        {
            **medians(by_simulator, False),
            **medians(by_simulator, True),
            **medians({f"noise {name}": rows for name, rows in by_setting.items()}, False),
        },
        least_samples(by_setting),
        float(np.median(lag)),
        {name: (mean, spread) for name, (mean, spread, _) in means.items()},
        {name: value for name, (_, _, (value, _, _)) in drawn.items()},
        {i: (n, beyond) for i, (n, _, beyond) in gained.items()},
        {i: (float(np.median(x)), float(x.max()), len(x)) for i, x in again.items()},
        [float(np.median(x)) for _, x in filtered],
    )
    return [
        *targets(measured), "",
        "Chi^2 per sample by simulator (1 is right; PB, RB are holds, PP and RP slides of pull and release).",
        "", *chi_squared(by_simulator, False, "simulator"), "",
        "The first half second of each phase.",
        "", *chi_squared(by_simulator, True, "simulator"), "",
        "By noise: white, coloured (mN) and its correlation time, all simulators.",
        "", *chi_squared(by_setting, False, "noise"), "",
        f"Correlation of neighbours after whitening: {_range(lag)} over {len(lag)} recordings.", "",
        *held(means), "",
        "What each candidate gains where nothing is missing, linearised, shapes in the middle of their range. By theory (Wilks",
        "1938) the mean is 1 and 5 % lie beyond.", "", *gains(gained), "",
        f"Twice the gain (nats) of an effect refitted with everything free: {refits}.", "",
        "Twice the log-likelihood ratio of a true effect over the base it contains, over draws of the noise. Theory: variance",
        "2 k + 4 D^2 for k strengths (noncentral chi^2). The noise is estimated anew on each draw.", "", *ratios(drawn), "",
        "D^2 that the estimated filter keeps of that of the exact covariance, computed densely from the true noise, for responses to",
        "theta and to six effects. Where a sensor has no slow noise and holds are too short to show that, a quarter of its white noise is",
        "believed to be slow, as sensors usually have it: D^2 is then less than it could be.", "", *dense(filtered), "",
    ]  # fmt: skip


def main() -> None:
    """Write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=7)
    parser.add_argument("--seed", type=int, default=515)
    parser.add_argument("--work", type=Path, default=ROOT / "build" / "likelihood")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "likelihood.md")
    args = parser.parse_args()
    np.seterr(all="ignore")
    kept = Kept(args.work)
    lines = page(kept, args.cases, args.seed)
    text = "\n".join(
        [
            "# Is the likelihood right?",
            "",
            "Recordings whose truth is known: the fast model itself and three simulators, benches and movements as the blind check",
            "draws them, 100-500 Hz, noise as stated. The model is fitted, the noise estimated from the recording, the residual",
            "whitened. Medians over recordings with their 90 % range. A line holds the extreme of its input, so that a smoothed input that",
            "wanders by its own error about a level at which the input stood takes it too far: where readings like that better, it stands still.",
            "",
            f"Numbers of commit {commit()}.",
            "",
            *lines,
            f"`make likelihood` ({args.cases} recordings a simulator and noise, seed {args.seed}, {kept.cpu_s() / 60.0:.0f} minutes of processor time). The",
            "filter itself is checked against the dense covariance in `tests/diagnosis/test_diagnosis_whitening.py` (equal to rounding).",
            "",
        ]
    )
    with atomic(args.out, force=True) as path:
        path.write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
