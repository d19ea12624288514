"""The paper's figures from our data: each knows its size, draws itself and describes itself in words."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sstl_cli.reporting import palette

Array = NDArray[np.float64]
PHASES = ("PB", "PP", "RB", "RP")


@dataclass(frozen=True)
class Drawing:
    """One figure in the form ``reporting.drawing`` takes: size (inch), grid of axes, drawing code, words."""

    name: str
    caption: str
    size: tuple[float, float]
    grid: tuple[int, int]
    paint: Callable[[Any], None]
    words: str

    def figure(self, data: Any) -> tuple[tuple[float, float], tuple[int, int]]:
        """Return size in inch and grid."""
        return self.size, self.grid

    def draw(self, axes: Any, data: Any) -> None:
        """Draw into the axes."""
        self.paint(axes)

    def alt(self, data: Any) -> str:
        """Describe the figure in words."""
        return self.words


@dataclass(frozen=True)
class Loop:
    """One segmented run: tensions (N), phase codes into ``names``, lines (gamma, beta) of pull and release."""

    system: str
    tension_in: Array
    tension_out: Array
    phase: NDArray[np.uint8]
    names: Sequence[str]
    theta: Mapping[str, float | None]


def loop(run: Loop) -> Drawing:
    """Return the four-phase loop (the paper's Fig. 4b)."""
    return Drawing(
        "loop",
        "Fig. 4b. Four-phase hysteresis loop of the actuation tendon.",
        (5.2, 4.0),
        (1, 1),
        lambda axes: _loop(axes, run, False),
        "Output against input tension of one actuation loop, coloured by phase.",
    )


def segmentation(runs: Sequence[Loop]) -> Drawing:
    """Return the segmented loops of both systems with their lines (Fig. 5)."""

    def paint(axes: Any) -> None:
        for panel, run in zip(axes.flat, runs, strict=True):
            _loop(panel, run, True)
            panel.set_title("actuation tendon" if run.system == "act" else "SSTL", loc="left")

    words = "; ".join(f"{r.system}: " + ", ".join(f"{k} {v:.3f}" for k, v in r.theta.items() if v is not None) for r in runs)
    return Drawing("segmentation", "Fig. 5. Segmentation and fitted lines of both systems.", (9.6, 3.9), (1, len(runs)), paint, words)


def correlation(act: Array, sstl: Array) -> Drawing:
    """Return SSTL slopes against squared actuation slopes with linear fit and identity (Fig. 6a)."""
    both = [_line(name, act[:, i] ** 2, sstl[:, i]) for i, name in enumerate(("pull", "release"))]

    def paint(axes: Any) -> None:
        for panel, line in zip(axes.flat, both, strict=True):
            ends = np.array([line.x.min(), line.x.max()])
            panel.plot(line.x, line.y, "o", markersize=4, color=palette.BLUE, label="configurations")
            panel.plot(ends, line.slope * ends + line.offset, color=palette.VERMILLION, label=f"fit {line.slope:.3f} x {line.offset:+.3f}")
            panel.plot(ends, ends, "--", linewidth=1, color=palette.INK, label="identity")
            panel.set_xlabel(f"(Γ {line.direction} of act)²")
            panel.set_ylabel(f"Γ {line.direction} of SSTL")
            panel.legend()

    return Drawing(
        "correlation",
        "Fig. 6a. SSTL slope against the squared actuation slope.",
        (9.6, 3.6),
        (1, 2),
        paint,
        f"{len(act)} configurations; " + "; ".join(line.words() for line in both) + ".",
    )


@dataclass(frozen=True)
class _Line:
    """SSTL slopes over squared actuation slopes of one direction, and the straight line through them."""

    direction: str
    x: Array
    y: Array
    slope: float
    offset: float

    def words(self) -> str:
        """Return how well the line and the identity fit, by their errors (RMS)."""
        off, same = (float(np.sqrt(np.mean((self.y - at) ** 2))) for at in (self.slope * self.x + self.offset, self.x))
        return f"{self.direction}: the straight line is off by {off:.2g}, the identity by {same:.2g}"


def _line(direction: str, x: Array, y: Array) -> _Line:
    slope, offset = np.polyfit(x, y, 1)
    return _Line(direction, x, y, float(slope), float(offset))


def product(lead: Array, act: Array, sstl: Array) -> Drawing:
    """Return the slope product over the lead (Fig. 6b)."""

    def paint(axes: Any) -> None:
        for values, name, colour in ((act, "act", palette.BLUE), (sstl, "SSTL", palette.VERMILLION)):
            p = values[:, 0] * values[:, 1]
            axes.plot(lead, p, "o", markersize=4, color=colour, label=f"{name}: {p.mean():.3f} ± {p.std(ddof=1):.3f}")
        axes.axhline(1.0, color=palette.INK, linewidth=0.8)
        axes.set_xlabel("lead / mm")
        axes.set_ylabel("Γp Γr")
        axes.legend()

    return Drawing(
        "product",
        "Fig. 6b. Slope product across bending configurations.",
        (6.4, 3.4),
        (1, 1),
        paint,
        "The product stays near 1 for the actuation tendon and below it for the SSTL.",
    )


def parameters(lead: Mapping[str, Array], values: Mapping[str, Mapping[str, Array]]) -> Drawing:
    """Return slopes and biases over the lead (Fig. 6c)."""

    def paint(axes: Any) -> None:
        for row, system in enumerate(("act", "sstl")):
            for panel, kind, unit in ((axes[row, 0], "gamma", ""), (axes[row, 1], "beta", " / N")):
                for d, colour in (("p", palette.BLUE), ("r", palette.VERMILLION)):
                    panel.plot(
                        lead[system],
                        values[system][f"{kind}_{d}"],
                        "o",
                        markersize=3.5,
                        color=colour,
                        label="pull" if d == "p" else "release",
                    )
                panel.set_ylabel(f"{'Γ' if kind == 'gamma' else 'β'} {system}{unit}")
                panel.set_xlabel("lead / mm")
                panel.legend()

    return Drawing(
        "parameters",
        "Fig. 6c. Identified slopes and biases over the bending lead.",
        (9.6, 5.6),
        (2, 2),
        paint,
        "Slopes move apart with the lead; biases scatter without a trend.",
    )


@dataclass(frozen=True)
class Tracked:
    """One tracked reference: time (s), reference and output (N) by method, and where it propagates while pulling."""

    name: str
    time_s: Array
    reference: Array
    outputs: Mapping[str, Array]
    pulling: NDArray[np.bool_]


SHOWN_S = 200.0
LABELS = {"none": "no compensation", "no-bias": "w/o bias", "DI": "direct identification", "proposed": "proposed"}


def tracking(runs: Sequence[Tracked], letter: str, trajectory: str) -> Drawing:
    """Return tracking at every location with all methods; of the sinusoid the error in pull propagation is shaded, as in the paper (Fig. 7)."""
    shades = letter == "a"

    def paint(axes: Any) -> None:
        for panel, run in zip(axes.flat, runs, strict=True):
            part = run.time_s - run.time_s[0] <= SHOWN_S
            time = run.time_s[part]
            panel.plot(time, run.reference[part], color=palette.INK, linewidth=1.2, label="reference")
            for method, out in run.outputs.items():
                colour = palette.METHODS.get(method, palette.GREY)
                panel.plot(time, out[part], color=colour, linewidth=0.9, label=LABELS.get(method, method))
            if shades:
                proposed = run.outputs["proposed"][part]
                panel.fill_between(
                    time, run.reference[part], proposed, where=run.pulling[part], color=palette.GREEN, alpha=0.3, linewidth=0
                )
            panel.set_title(run.name, loc="left")
            panel.set_xlabel("time / s")
            panel.set_ylabel("output tension / N")
        # above the panels: within one it would hide curves
        axes[0, 0].figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper right", ncols=len(runs[0].outputs) + 1)

    worst = {m: float(np.sqrt(np.mean((runs[0].outputs[m] - runs[0].reference) ** 2))) for m in runs[0].outputs}
    return Drawing(
        f"tracking_{trajectory}",
        f"Fig. 7{letter}. Tension tracking on the rig (block R), {trajectory} reference, first {SHOWN_S:.0f} s"
        + ("; shaded: error of the proposed method in pull propagation." if shades else "."),
        (11.0, 3.8),
        (1, len(runs)),
        paint,
        f"RMSE at {runs[0].name}: " + ", ".join(f"{LABELS.get(m, m)} {v:.2f} N" for m, v in worst.items()) + ".",
    )


def ablation(errors: Mapping[str, Array], limit: float) -> Drawing:
    """Return the total error of every variant over seeds with the limit of the data (Table III)."""

    def paint(axes: Any) -> None:
        for i, values in enumerate(errors.values()):
            total = values[:, 2]
            axes.plot(total, np.full(len(total), i) + np.linspace(-0.15, 0.15, len(total)), ".", color=palette.BLUE)
            axes.plot([total.mean()], [i], "D", color=palette.VERMILLION)
        axes.axvline(limit, color=palette.INK, linestyle="--", linewidth=1)
        axes.text(limit, -0.6, " limit", va="top", fontsize=8)
        axes.set_yticks(range(len(errors)), list(errors))
        axes.invert_yaxis()
        axes.set_xlabel("total RMSE on held-out configurations")

    best = min(errors, key=lambda n: float(errors[n][:, 2].mean()))
    return Drawing(
        "ablation",
        "Mapping variants over seeds (dots), their mean (diamond), the limit of the data (dashed).",
        (7.0, 3.2),
        (1, 1),
        paint,
        f"Lowest mean total error: {best}; the limit is {limit:.4f}.",
    )


def ladder(names: Sequence[str], values: Mapping[str, Sequence[float]], targets: Mapping[str, float]) -> Drawing:
    """Return RMSE of every set of means on the rig, beside the paper's direct identification."""

    def paint(axes: Any) -> None:
        place = np.arange(len(names))
        for k, (name, colour) in enumerate((("sinusoid", palette.BLUE), ("random", palette.ORANGE))):
            axes.barh(place + 0.38 * k - 0.19, values[name], 0.36, color=colour, label=name)
            axes.axvline(targets[name], color=colour, linestyle="--", linewidth=1)
        axes.set_yticks(place, list(names))
        axes.invert_yaxis()
        axes.set_xlabel("RMSE / N (dashed: the paper's direct identification)")
        axes.legend()

    return Drawing(
        "better",
        "What every means adds on the rig.",
        (8.6, 4.8),
        (1, 1),
        paint,
        "; ".join(f"{n}: {values['sinusoid'][i]:.2f} and {values['random'][i]:.2f} N" for i, n in enumerate(names)),
    )


def probe(curves: Mapping[tuple[str, str], tuple[Array, Array, Array]]) -> Drawing:
    """Return Theta error and tracking error of full strokes over the probe's time, by rig and calibration."""

    def paint(axes: Any) -> None:
        looks = zip("os^", (palette.BLUE, palette.VERMILLION, palette.GREEN), strict=True)
        for ((rig, calibration), (time, lines, tracked)), (marker, colour) in zip(curves.items(), looks, strict=False):
            look = {"marker": marker, "markersize": 4, "color": colour, "label": f"{rig}, calibrated at {calibration}"}
            axes[0, 0].plot(time, 100 * lines, **look)
            axes[0, 1].plot(time, tracked, **look)
        times = sorted({float(t) for time, _, _ in curves.values() for t in time})
        axes[0, 0].set_ylabel("error of the slopes / %")
        axes[0, 1].set_ylabel("RMSE on the sinusoid / N")
        for panel in axes.flat:
            panel.set_xscale("log")
            # powers of ten would be written as formulas, which no text here is taken for
            panel.set_xticks(times, [f"{t:g}" for t in times], minor=False)
            panel.set_xticks([], minor=True)
            panel.set_xlabel("time of the probe / s")
            panel.set_ylim(bottom=0)
            panel.legend()

    words = "; ".join(
        f"{rig}, {calibration}: {time[-1]:g} s errs by {100 * lines[-1]:.1f} % and {tracked[-1]:.2f} N, {time[0]:g} s by "
        f"{100 * lines[0]:.1f} % and {tracked[0]:.2f} N"
        for (rig, calibration), (time, lines, tracked) in curves.items()
    )
    return Drawing("probe", "Errors over the time of the probe.", (9.6, 3.6), (1, 2), paint, words)


def _loop(axes: Any, run: Loop, lines: bool) -> None:
    for code, name in enumerate(run.names):
        if name not in PHASES:
            continue
        inside = run.phase == code
        out = np.where(inside, run.tension_out, np.nan)[::5]
        axes.plot(run.tension_in[::5], out, color=palette.PHASES[name], linewidth=1.8, label=name)
    if lines:
        low, high = float(run.tension_in.min()), float(run.tension_in.max())
        top = 1.05 * float(run.tension_out.max())
        for d, style in (("p", "-"), ("r", "--")):
            gamma, beta = run.theta[f"gamma_{d}"], run.theta[f"beta_{d}"]
            if gamma is None or beta is None:
                continue
            ends = np.array([low, min(high, (top - beta) / gamma)])
            axes.plot(ends, gamma * ends + beta, style, color=palette.INK, linewidth=0.9, label=f"{gamma:.3f} x {beta:+.3f}")
    axes.set_xlabel("input tension / N")
    axes.set_ylabel("output tension / N")
    axes.legend()
