"""The pictures of a campaign: how often flights fail over an input, and how results spread."""

from __future__ import annotations

import io
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from stator.campaign.columns import unit_of
from stator.flight.plot import ESTIMATE, FAILED, SETPOINT, TRUTH, save

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.figure import Figure

    from stator.campaign.statistics import Crossing, Point

GROUPS = 24


def draw_curve(
    points: list[Point],
    label: str,
    file: Path | io.BytesIO,
    found: tuple[float, Crossing] | None = None,
) -> None:
    """`found`: the share that was asked for, and where the curve goes beyond it."""
    figure = _figure(8.0, 3.6)
    axes = figure.subplots()
    at = [point.at for point in points]
    low, high = (100 * np.array([point.interval[i] for point in points]) for i in (0, 1))
    share = 100 * np.array([point.share for point in points])
    errors = [np.maximum(share - low, 0.0), np.maximum(high - share, 0.0)]
    axes.errorbar(at, share, yerr=errors, fmt="o-", color=ESTIMATE, ecolor=TRUTH, capsize=3)
    if found is not None:
        wanted, crossing = found
        axes.axhline(100 * wanted, color=SETPOINT, linewidth=1)
        if math.isfinite(crossing.at):
            axes.axvline(crossing.at, color=FAILED, linewidth=1)
            end = crossing.high if math.isfinite(crossing.high) else max(at)
            axes.axvspan(crossing.low, end, color=FAILED, alpha=0.15, linewidth=0)
            text = f"{100 * wanted:g} % at {crossing.at:.3g}"
            axes.text(0.02, 0.9, text, transform=axes.transAxes, color=FAILED)
    axes.set_ylim(-2.0, 102.0)
    axes.set_xlabel(label)
    axes.set_ylabel("failed flights (%)")
    axes.grid(color="#e0e0e0", linewidth=0.6)
    _write(figure, file)


def draw_spread(rows: list[dict[str, Any]], columns: list[str], file: io.BytesIO) -> None:
    """How the results of good and of failed flights spread."""
    across = min(3, len(columns))
    down = math.ceil(len(columns) / across)
    figure = _figure(3.4 * across, 2.2 * down)
    for axes, column in zip(
        figure.subplots(down, across, squeeze=False).flat, columns, strict=False
    ):
        values = {
            good: [r[column] for r in rows if r["success"] == good and _is_number(r[column])]
            for good in (True, False)
        }
        ends = np.histogram_bin_edges([*values[True], *values[False]], GROUPS)
        shown = [values[True], values[False]]
        axes.hist(shown, ends, stacked=True, color=[ESTIMATE, FAILED], label=["good", "failed"])
        axes.set_title(column, fontsize=9)
        axes.set_xlabel(unit_of(column), fontsize=8)
        axes.tick_params(labelsize=8)
    figure.axes[0].legend(fontsize=8)
    for axes in figure.axes[len(columns) :]:
        axes.set_axis_off()
    _write(figure, file)


def _is_number(value: Any) -> bool:
    return value is not None and math.isfinite(value)


def _figure(width: float, height: float) -> Figure:
    import matplotlib as mpl

    mpl.use("Agg")
    mpl.rcParams["svg.hashsalt"] = "stator"
    from matplotlib import pyplot

    return pyplot.figure(figsize=(width, height), dpi=120, layout="constrained")


def _write(figure: Figure, file: Path | io.BytesIO) -> None:
    from matplotlib import pyplot

    if isinstance(file, io.BytesIO):
        figure.savefig(file, format="png", metadata={"Software": None})
    else:
        save(figure, file)
    pyplot.close(figure)
