"""Layouts of the standard plots of a flight, for PlotJuggler and for Foxglove. A plot has what of
its fields the log has."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

if TYPE_CHECKING:
    from pathlib import Path

    from stator.convert.topics import Topic

    Curve = tuple[str, str, int | None]  # topic, field, element of an array
    Plots = list[tuple[str, list[Curve]]]

ROTORS = 12
# Colour-blind safe (Okabe and Ito).
COLOURS = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#d55e00", "#56b4e9")


def _axes(topic: str, field: str, count: int = 3) -> list[Curve]:
    return [(topic, field, i) for i in range(count)]


def _fields(topic: str, *fields: str) -> list[Curve]:
    return [(topic, field, None) for field in fields]


STANDARD: Plots = [
    (
        "height (down)",
        [*_fields("vehicle_local_position", "z"), ("trajectory_setpoint", "position", 2)],
    ),
    (
        "position (north, east)",
        [
            *_fields("vehicle_local_position", "x", "y"),
            *_axes("trajectory_setpoint", "position", 2),
        ],
    ),
    (
        "velocity",
        [
            *_fields("vehicle_local_position", "vx", "vy", "vz"),
            *_axes("trajectory_setpoint", "velocity"),
        ],
    ),
    ("attitude (w, x, y, z)", _axes("vehicle_attitude", "q", 4)),
    (
        "rates",
        [*_axes("sensor_gyro", "xyz"), *_fields("vehicle_rates_setpoint", "roll", "pitch", "yaw")],
    ),
    ("torque", _axes("vehicle_torque_setpoint", "xyz")),
    ("motors", _axes("actuator_motors", "control", ROTORS)),
    ("mode", _fields("vehicle_status", "nav_state", "arming_state", "failsafe")),
    ("battery", _fields("battery_status", "voltage_v", "current_a", "remaining")),
]


def plots_of(topics: list[Topic]) -> Plots:
    """The standard plots, with the fields of the log. An element without any number is left out,
    such as a motor that the vehicle does not have."""
    known = {
        (topic.name, field.name, i if field.is_array else None)
        for topic in topics
        for field in topic.fields
        for i, column in enumerate(field.columns)
        if (column == column).any()  # NaN differs from itself
    }
    found = [(name, [curve for curve in curves if curve in known]) for name, curves in STANDARD]
    return [(name, curves) for name, curves in found if curves]


def write_plotjuggler(topics: list[Topic], output: Path) -> None:
    """For the ULog file itself. PlotJuggler names its curves `topic/field.00`."""
    root = ElementTree.Element("root")
    window = {"name": "Main Window", "parent": "main_window"}
    widget = ElementTree.SubElement(root, "tabbed_widget", window)
    tab = ElementTree.SubElement(widget, "Tab", tab_name="flight", containers="1")
    plots = plots_of(topics)
    box = _splitter(ElementTree.SubElement(tab, "Container"), "|", 2)
    for column in (plots[0::2], plots[1::2]):
        rows = _splitter(box, "-", max(len(column), 1))
        for name, curves in column:
            area = ElementTree.SubElement(rows, "DockArea", name=name)
            words = {"mode": "TimeSeries", "style": "Lines", "flip_x": "false", "flip_y": "false"}
            plot = ElementTree.SubElement(area, "plot", words)
            for i, (topic, field, element) in enumerate(curves):
                number = "" if element is None else f".{element:02d}"
                colour = COLOURS[i % len(COLOURS)]
                ElementTree.SubElement(plot, "curve", name=f"{topic}/{field}{number}", color=colour)
    ElementTree.SubElement(widget, "currentTabIndex", index="0")
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(output, encoding="UTF-8", xml_declaration=True)


def _splitter(parent: ElementTree.Element, orientation: str, count: int) -> ElementTree.Element:
    sizes = ";".join([f"{1 / count:.6f}"] * count)
    words = {"orientation": orientation, "count": str(count), "sizes": sizes}
    return ElementTree.SubElement(parent, "DockSplitter", words)


def write_foxglove(topics: list[Topic], output: Path) -> None:
    """For MCAP and for a live view."""
    panels: dict[str, Any] = {}
    for number, (name, curves) in enumerate(plots_of(topics)):
        panels[f"Plot!{number}"] = {
            "foxglovePanelTitle": name,
            "paths": [
                {
                    "value": f"/{topic}.{field}" + ("" if i is None else f"[{i}]"),
                    "enabled": True,
                    "timestampMethod": "receiveTime",
                }
                for topic, field, i in curves
            ],
            "showLegend": True,
            "isSynced": True,
            "xAxisVal": "timestamp",
        }
    names = list(panels)
    columns = [_stacked(names[0::2]), _stacked(names[1::2])]
    layout = {
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": {"first": columns[0], "second": columns[1], "direction": "row"}
        if columns[1]
        else columns[0],
    }
    output.write_text(json.dumps(layout, indent=2) + "\n", encoding="utf-8")


def _stacked(names: list[str]) -> Any:
    """Panels of equal height, one above the other."""
    if len(names) < 2:
        return names[0] if names else ""
    return {
        "first": names[0],
        "second": _stacked(names[1:]),
        "direction": "column",
        "splitPercentage": 100 / len(names),
    }
