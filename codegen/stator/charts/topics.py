"""Topics of one log or several over time: one panel for each quantity."""

from __future__ import annotations

import contextlib
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stator.charts.differences import LETTERS
from stator.diagnostics import Failed, UserError, nearest, shown_path
from stator.flight.log import seconds
from stator.flight.pictures import modes_of_log, open_log, report_beside
from stator.flight.plot import LINES, bands, save
from stator.pipeline import make_plan

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from pyulog import ULog

    from stator.graph.model import Graph

MAX_PANELS = 12
# Of several flights, the others are thin lines upon the first one's broad and pale one.
WIDTHS, STRENGTHS = (2.6, 1.0), (0.4, 1.0)
ELEMENT = re.compile(r"(.+)\[\d+\]")


@dataclass(frozen=True)
class Quantity:
    topic: str
    field: str  # as the message has it, or one element of it
    columns: tuple[str, ...]  # of pyulog: one for each element
    unit: str

    @property
    def name(self) -> str:
        return f"{self.topic}.{self.field}"


def draw_topics(logs: list[Path], wanted: list[str], output: Path) -> None:
    """Raises `UserError` for what a log does not have."""
    opened = [open_log(log) for log in logs]
    graph = _graph_of(logs[0])
    quantities = [
        quantity
        for text in wanted
        for quantity in _quantities(opened[0], text, graph, shown_path(logs[0]))
    ]
    if len(quantities) > MAX_PANELS:
        raise UserError(
            f"error: expected at most {MAX_PANELS} quantities, found {len(quantities)}\n"
            "hint: name fields, as in --topic vehicle_attitude.q"
        )
    for log, path in zip(opened[1:], logs[1:], strict=True):
        for quantity in quantities:
            _quantities(log, quantity.name, graph, shown_path(path))
    save(_figure(logs, opened, quantities), output)


def _quantities(log: ULog, text: str, graph: Graph | None, file: str) -> list[Quantity]:
    name, dot, field = text.partition(".")
    columns = _columns(log, name)
    if columns is None and graph is not None and name in graph.topics:
        raise UserError(
            f"error: topic '{name}' has no sample in the log '{file}'\n"
            "hint: it was not published in this flight, or the graph says `log: none`"
        )
    if columns is None:
        known = {dataset.name for dataset in log.data_list}
        raise UserError(
            f"error: unknown topic '{name}' of the log '{file}'\nhint: {nearest(name, known)}"
        )
    fields = [field] if dot else list(dict.fromkeys(map(_field, columns)))
    found = []
    for one in fields:
        own = tuple(c for c in columns if one in (c, _field(c)))
        if not own:
            known = {_field(column) for column in columns}
            raise UserError(
                f"error: unknown field '{field}' of topic '{name}'\nhint: {nearest(field, known)}"
            )
        found.append(Quantity(name, one, own, _unit(graph, name, _field(one))))
    return found


def _columns(log: ULog, topic: str) -> list[str] | None:
    for dataset in log.data_list:
        if dataset.name == topic:
            return [c for c in dataset.data if not c.startswith(("timestamp", "_padding"))]
    return None


def _field(column: str) -> str:
    """`q[1]` -> `q`."""
    match = ELEMENT.fullmatch(column)
    return match[1] if match else column


def _graph_of(log: Path) -> Graph | None:
    """The graph that flew, for units: a log has none."""
    with contextlib.suppress(Failed, UserError, KeyError, OSError):
        return make_plan(str(report_beside(log)["graph_file"]), None).graph
    return None


def _unit(graph: Graph | None, topic: str, field: str) -> str:
    if graph is None or topic not in graph.topics:
        return ""
    fields = graph.topics[topic].message.fields
    unit = next((f.unit for f in fields if f.name == field), None)
    return unit or ""


def _figure(logs: list[Path], opened: list[ULog], quantities: list[Quantity]) -> Figure:
    import matplotlib as mpl

    mpl.use("Agg")
    mpl.rcParams["svg.hashsalt"] = "stator"
    from matplotlib import pyplot

    count = len(quantities)
    figure, areas = pyplot.subplots(
        count,
        1,
        sharex=True,
        squeeze=False,
        figsize=(12.0, 1.4 + 1.9 * count),
        dpi=150,
        layout="constrained",
    )
    for axes, quantity in zip(areas[:, 0], quantities, strict=True):
        bands(axes, list(modes_of_log(opened[0])), named=axes is areas[0, 0])
        for i, log in enumerate(opened):
            _paint(axes, log, quantity, i, logs)
        unit = f" ({quantity.unit})" if quantity.unit not in ("", "1") else ""
        axes.set_ylabel(f"{quantity.topic}\n{quantity.field}{unit}", fontsize=8)
        axes.margins(x=0.0)
        axes.grid(color="#e0e0e0", lw=0.5)
        if len(logs) > 1 or len(quantity.columns) > 1:
            axes.legend(fontsize=7, ncols=4, loc="upper right")
    areas[-1, 0].set_xlabel("time (s)")
    figure.suptitle(" and ".join(log.stem for log in logs), fontsize=11)
    return figure


def _paint(axes: Axes, log: ULog, quantity: Quantity, number: int, logs: list[Path]) -> None:
    """Colours tell elements apart, or the logs of a quantity that has one element."""
    data: dict[str, Any] = next(d.data for d in log.data_list if d.name == quantity.topic)
    time_s = seconds(data["timestamp"])
    alone = len(quantity.columns) == 1
    for i, column in enumerate(quantity.columns):
        values = np.asarray(data[column], dtype=float)
        if np.isnan(values).all() and not alone:
            continue  # such as motors that the vehicle does not have
        if np.isnan(values).all():
            axes.text(0.5, 0.5, "not a number throughout", transform=axes.transAxes, ha="center")
        label = column if not alone else ""
        if len(logs) > 1:
            label = f"{LETTERS[number]}{' ' if label else ''}{label}"
        axes.plot(
            time_s,
            values,
            color=LINES[(number if alone else i) % len(LINES)],
            lw=WIDTHS[min(number, 1)] if len(logs) > 1 else 1.0,
            alpha=STRENGTHS[min(number, 1)] if len(logs) > 1 else 1.0,
            label=label,
        )
