"""Flights in one picture: path, altitude, tilt, error and motors."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stator.charts.differences import LETTERS
from stator.flight.pictures import Flown, Series, read
from stator.flight.plot import SETPOINT, distance, euler_deg, save, square

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.axes import Axes

    from stator.flight.log import Floats

# Colour-blind safe; one for each flight.
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#999999", "#000000")
STYLES = ("-", (0, (4, 1.5)))  # by turns


def draw_overlay(logs: list[Path], output: Path, title: str) -> None:
    """Raises `UserError` for a log without a path."""
    import matplotlib as mpl

    mpl.use("Agg")
    mpl.rcParams["svg.hashsalt"] = "stator"
    from matplotlib import pyplot

    flights = [read(log) for log in logs]
    figure = pyplot.figure(figsize=(12.0, 7.2), dpi=150, layout="constrained")
    panels = {"altitude (m)": _altitude, "tilt (deg)": _tilt, "error (m)": _error}
    panels["motors, mean (%)"] = _motors
    areas = figure.subplot_mosaic([["map", name] for name in panels], width_ratios=[1.0, 1.3])
    for number, flown in enumerate(flights):
        _path(areas["map"], flown, number)
        for name, series in panels.items():
            found = series(flown)
            if found is not None:
                areas[name].plot(*found, color=COLOURS[number], ls=STYLES[number % 2], lw=1.1)
    if flights[0].setpoint is not None:
        time_s, down = flights[0].setpoint.time_s, flights[0].setpoint.values[:, 2]
        areas["altitude (m)"].plot(time_s, -down, color=SETPOINT, lw=0.9, ls=":", zorder=1)
    last = list(panels)[-1]
    for name in panels:
        axes = areas[name]
        axes.set_ylabel(name)
        axes.sharex(areas[last])
        axes.tick_params(labelbottom=name == last)
        axes.margins(x=0.0)
        axes.grid(color="#e0e0e0", lw=0.5)
    areas[last].set_xlabel("time (s)")
    square(areas["map"])
    areas["map"].set_xlabel("east (m)")
    areas["map"].set_ylabel("north (m)")
    areas["map"].grid(color="#e0e0e0", lw=0.5)
    areas["map"].legend(fontsize=8, loc="upper right")
    figure.suptitle(title, fontsize=11, wrap=True)
    save(figure, output)


def _path(axes: Axes, flown: Flown, number: int) -> None:
    place = _position(flown)
    if place is not None:
        north, east, _ = place.values.T
        label = f"{LETTERS[number]}: {flown.title}"
        axes.plot(east, north, color=COLOURS[number], ls=STYLES[number % 2], lw=1.1, label=label)
        axes.plot(east[-1], north[-1], "s", color=COLOURS[number], ms=5, zorder=4)


def _position(flown: Flown) -> Series | None:
    """The true one where it is known: estimates of two flights err differently."""
    if flown.truth is not None:
        return Series(flown.truth.time_s, flown.truth.position)
    return flown.position


def _altitude(flown: Flown) -> tuple[Floats, Floats] | None:
    place = _position(flown)
    return None if place is None else (place.time_s, -place.values[:, 2])


def _tilt(flown: Flown) -> tuple[Floats, Floats] | None:
    if flown.truth is not None:
        time_s, q = flown.truth.time_s, flown.truth.q
    elif flown.attitude is not None:
        time_s, q = flown.attitude.time_s, flown.attitude.values
    else:
        return None
    roll, pitch, _ = np.radians(euler_deg(q)).T
    return time_s, np.degrees(np.arccos(np.clip(np.cos(roll) * np.cos(pitch), -1.0, 1.0)))


def _error(flown: Flown) -> tuple[Floats, Floats] | None:
    place = _position(flown)
    if flown.setpoint is None or place is None:
        return None
    # At the setpoint's own times: between them it only stays where it was.
    time_s = flown.setpoint.time_s
    columns = [np.interp(time_s, place.time_s, column) for column in place.values.T]
    return distance(flown, flown.setpoint, Series(time_s, np.column_stack(columns)))


def _motors(flown: Flown) -> tuple[Floats, Floats] | None:
    if flown.motors is None:
        return None
    return flown.motors.time_s, 100.0 * flown.motors.values.mean(axis=1)
