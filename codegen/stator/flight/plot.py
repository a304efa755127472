"""Draws a flight as one picture."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from stator.diagnostics import UserError
from stator.flight.pictures import Flown, Mode, Series, read

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from stator.flight.log import Floats

FORMATS = (".png", ".svg", ".pdf")
MIN_MAP_M = 2.0
LEAST_NAMED = 0.03  # of the whole time, of a band with a name
LETTER = 0.012  # the width of one, of the whole time
HALF_TURN_DEG = 180.0
# Colour-blind safe (Okabe and Ito); each colour has one meaning in all panels.
# The truth is a wide line below the estimate, so that differences are visible.
TRUTH, ESTIMATE, SETPOINT, FAILED = "#b0b0b0", "#0072b2", "#e69f00", "#d55e00"
TRUTH_WIDTH = 2.6
LINES = ("#0072b2", "#e69f00", "#009e73", "#cc79a7")
BANDS = ("#f0f0f0", "#dcebf5", "#e5f3e6", "#fdf1d8", "#f3e3ee", "#e8e8f8")


def draw(log: Path, output: Path) -> None:
    """Raises `UserError` for an unreadable log or an unknown file format."""
    check_format(output)
    save(_figure(read(log)), output)


def check_format(output: Path) -> None:
    if output.suffix not in FORMATS:
        raise UserError(
            f"error: expected a file name that ends in {', '.join(FORMATS)}, found "
            f"'{output.name}'\nhint: write for example flight.png"
        )


def save(figure: Figure, output: Path) -> None:
    check_format(output)
    try:
        # No date and no version: the same flight gives the same bytes.
        metadata = {"Date": None} if output.suffix == ".svg" else {"Software": None}
        output.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(output, metadata=metadata if output.suffix != ".pdf" else None)
    except OSError as error:
        raise UserError(f"error: cannot write '{output}': {error.strerror}") from None


def _figure(flown: Flown) -> Figure:
    import matplotlib as mpl

    mpl.use("Agg")
    mpl.rcParams["svg.hashsalt"] = "stator"
    from matplotlib import pyplot

    figure = pyplot.figure(figsize=(12.0, 7.2), dpi=150, layout="constrained")
    areas = figure.subplot_mosaic(
        [["map", "altitude"], ["map", "attitude"], ["map", "error"], ["map", "motors"]],
        width_ratios=[1.0, 1.3],
    )
    _draw_map(areas["map"], flown)
    times = ["altitude", "attitude", "error", "motors"]
    for name, paint in zip(times, (_altitude, _attitude, _error, _motors), strict=True):
        bands(areas[name], flown.modes, named=name == times[0])
        paint(areas[name], flown)
        areas[name].sharex(areas[times[-1]])
        areas[name].tick_params(labelbottom=name == times[-1])
        areas[name].margins(x=0.0)
        _legend(areas[name])
    areas["motors"].set_xlabel("time (s)")
    _title(figure, flown)
    return figure


def _title(figure: Figure, flown: Flown) -> None:
    facts = flown.facts
    if not facts:
        figure.suptitle(flown.title)
        return
    good = bool(facts.get("success"))
    text = f"{flown.title}, seed {facts.get('seed')}: "
    text += str(facts.get("reason")) if good else f"FAILED: {facts.get('reason')}"
    figure.suptitle(text, color="black" if good else FAILED, fontsize=11, wrap=True)


def _draw_map(axes: Axes, flown: Flown) -> None:
    if flown.truth is not None:
        north, east, _ = flown.truth.position.T
        axes.plot(east, north, color=TRUTH, lw=TRUTH_WIDTH, label="truth")
        axes.plot(east[0], north[0], "o", color="black", ms=5, label="start", zorder=4)
        axes.plot(east[-1], north[-1], "s", color="black", ms=5, label="end", zorder=4)
    if flown.setpoint is not None:
        north, east, _ = flown.setpoint.values.T
        axes.plot(east, north, color=SETPOINT, lw=1.0, ls="--", label="setpoint")
    if flown.position is not None:
        north, east, _ = flown.position.values.T
        axes.plot(east, north, color=ESTIMATE, lw=1.0, label="estimate")
    for problem in flown.facts.get("problems", []):
        if problem.get("position_m") is not None:
            north_m, east_m, _ = problem["position_m"]
            axes.plot(east_m, north_m, "X", color=FAILED, ms=9, zorder=5, label="limit broken")
    _wind(axes, flown)
    square(axes)
    axes.set_xlabel("east (m)")
    axes.set_ylabel("north (m)")
    axes.set_title("path", fontsize=10)
    axes.grid(color="#e0e0e0", lw=0.5)
    _legend(axes)


def square(axes: Axes) -> None:
    """The same scale on both axes, and a minimum size: a hover of centimetres stays small."""
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    side = max(right - left, high - low, MIN_MAP_M)
    axes.set_xlim((left + right - side) / 2, (left + right + side) / 2)
    axes.set_ylim((low + high - side) / 2, (low + high + side) / 2)
    axes.set_aspect("equal")


def _wind(axes: Axes, flown: Flown) -> None:
    """Above the map, an arrow in the direction of the mean wind, with its speed."""
    wind = float(flown.facts.get("wind_m_s") or 0.0)
    if wind == 0.0:
        return
    to = np.radians(float(flown.facts.get("wind_from_deg") or 0.0) + 180.0)
    step = 0.025 * np.array([np.sin(to), np.cos(to)])
    middle = np.array([0.03, 1.04])
    axes.annotate(
        "",
        xy=tuple(middle + step),
        xytext=tuple(middle - step),
        xycoords="axes fraction",
        arrowprops={"arrowstyle": "-|>", "color": "#555555", "lw": 1.5},
        annotation_clip=False,
    )
    axes.text(0.07, 1.03, f"wind {wind:g} m/s", transform=axes.transAxes, fontsize=8)


def _altitude(axes: Axes, flown: Flown) -> None:
    if flown.truth is not None:
        time_s, down = flown.truth.time_s, flown.truth.position[:, 2]
        axes.plot(time_s, -down, color=TRUTH, lw=TRUTH_WIDTH)
    if flown.setpoint is not None:
        axes.plot(flown.setpoint.time_s, -flown.setpoint.values[:, 2], "--", color=SETPOINT, lw=1.0)
    if flown.position is not None:
        axes.plot(flown.position.time_s, -flown.position.values[:, 2], color=ESTIMATE, lw=1.0)
    axes.set_ylabel("altitude (m)")


def _attitude(axes: Axes, flown: Flown) -> None:
    if flown.truth is not None:
        for angle in euler_deg(flown.truth.q).T:
            axes.plot(flown.truth.time_s, angle, color=TRUTH, lw=TRUTH_WIDTH)
    if flown.attitude is not None:
        angles = euler_deg(flown.attitude.values)
        for name, angle, color in zip(("roll", "pitch", "yaw"), angles.T, LINES, strict=False):
            axes.plot(flown.attitude.time_s, angle, color=color, lw=1.0, label=name)
    axes.set_ylabel("attitude (deg)")


def _error(axes: Axes, flown: Flown) -> None:
    """Distance from the setpoint in the air, of truth and of estimate."""
    axes.set_ylabel("error (m)")
    if flown.setpoint is None:
        return
    if flown.truth is not None:
        true = Series(flown.truth.time_s, flown.truth.position)
        axes.plot(*distance(flown, flown.setpoint, true), color=TRUTH, lw=TRUTH_WIDTH)
    if flown.position is not None:
        axes.plot(*distance(flown, flown.setpoint, flown.position), color=ESTIMATE, lw=1.0)
    for problem in flown.facts.get("problems", []):
        if problem.get("time_s") is not None:
            axes.axvline(problem["time_s"], color=FAILED, lw=1.5)
    axes.set_ylim(bottom=0.0)


def distance(flown: Flown, setpoint: Series, position: Series) -> tuple[Floats, Floats]:
    index = np.searchsorted(setpoint.time_s, position.time_s, side="right") - 1
    known = (index >= 0) & (position.time_s < (flown.facts.get("touchdown_s") or np.inf))
    off = position.values[known] - setpoint.values[index[known]]
    # A coordinate without a setpoint is free.
    free = np.isnan(off).all(axis=1)
    length = np.linalg.norm(np.nan_to_num(off), axis=1)
    length[free] = np.nan
    return position.time_s[known], length


def _motors(axes: Axes, flown: Flown) -> None:
    axes.set_ylabel("motors (%)")
    if flown.motors is None:
        return
    for rotor, command in enumerate(flown.motors.values.T):
        turn, line = divmod(rotor, len(LINES))
        axes.plot(
            flown.motors.time_s,
            100.0 * command,
            color=LINES[line],
            ls=("-", "--", ":")[turn],
            lw=0.8,
            label=str(rotor + 1),
        )
    axes.set_ylim(0.0, 100.0)


def bands(axes: Axes, modes: list[Mode], *, named: bool) -> None:
    """The flight modes as bands behind the curves, each in its own shade."""
    names = list(dict.fromkeys(name for _, _, name in modes))
    shades = {name: BANDS[i % len(BANDS)] for i, name in enumerate(names)}
    whole = modes[-1][1] - modes[0][0] if modes else 0.0
    taken = [-math.inf, -math.inf]  # where the texts of each row end
    for begin, end, name in modes:
        axes.axvspan(begin, end, color=shades[name], lw=0.0, zorder=0)
        if not named or end - begin <= LEAST_NAMED * whole:
            continue
        middle, half = (begin + end) / 2, LETTER * len(name) * whole / 2
        row = 0 if middle - half > taken[0] else 1
        if middle - half > taken[row]:
            taken[row] = middle + half
            place, y = axes.get_xaxis_transform(), 1.02 + 0.1 * row
            axes.text(middle, y, name, transform=place, ha="center", fontsize=8)


def _legend(axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    once = dict(zip(labels, handles, strict=True))
    if once:
        axes.legend(once.values(), once.keys(), fontsize=7, ncols=len(once), loc="upper right")


def euler_deg(q: Floats) -> Floats:
    """Roll, pitch, yaw of q_NB (w x y z), for people."""
    w, x, y, z = q.T
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2 * (w * y - z * x), -1.0, 1.0))
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    angles: Floats = np.degrees(np.column_stack([roll, pitch, yaw]))
    # No line across the picture where an angle goes from 180 to -180.
    angles[1:][np.abs(np.diff(angles, axis=0)) > HALF_TURN_DEG] = np.nan
    return angles
