"""`./stator param`: lists, changes, saves and loads the parameters of a vehicle that runs; of a
log, lists and saves them."""

from __future__ import annotations

import argparse
import contextlib
import json
import sys
from typing import TYPE_CHECKING, Any

from stator.arguments import path
from stator.diagnostics import ANSWER_IS_NO, UserError, shown_path
from stator.live.arguments import add_link_arguments
from stator.live.link import Link
from stator.params import file
from stator.params.source import STATES, Log, Vehicle
from stator.params.table import Row, Value, find, in_words, read_text

if TYPE_CHECKING:
    from collections.abc import Iterator

WHY = {
    "no_node": ("the graph has no node that changes parameters", "include parts/parameters.yaml"),
    "fixed": ("it cannot change while the graph runs", "write the value in the graph"),
    "armed": ("it changes only while the vehicle is disarmed", "disarm it first"),
}
COUNTS = {
    "redefined": "whose record has another type or unit",
    "out_of_range": "whose record is out of range now",
    "withheld": "whose record is not used, since the starts before this one ended within 5 s",
    "refused": "that count until the restart only: the memory is full or has failed",
    "pending": "not kept yet",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    listed = _action(actions, "list", "all parameters; * marks what differs from the graph")
    listed.add_argument("--changed", action="store_true", help="only what differs from the graph")
    one = _action(actions, "get", "one parameter")
    one.add_argument("name", metavar="NAME", help="id, or NODE.PARAMETER")
    new = _action(actions, "set", "change a parameter, and keep it", of_log=False)
    new.add_argument("name", metavar="NAME", help="id, or NODE.PARAMETER")
    new.add_argument("value", metavar="VALUE", help="such as 5, '5 m/s' or true")
    save = _action(actions, "save", "write all to a file of QGroundControl")
    save.add_argument("file", type=path, metavar="FILE")
    load = _action(
        actions, "load", "take what a file has: QGroundControl's or MAVProxy's", of_log=False
    )
    load.add_argument("file", type=path, metavar="FILE")
    reset = _action(actions, "reset", "back to the graph's values", of_log=False)
    reset.add_argument("names", nargs="*", metavar="NAME", help="only these (default: all)")


def _action(actions: Any, name: str, text: str, *, of_log: bool = True) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = actions.add_parser(name, help=text, description=text)
    add_link_arguments(parser)
    if of_log:
        parser.add_argument(
            "--log",
            type=path,
            metavar="FILE",
            help="of this flight, in place of a vehicle that runs",
        )
    return parser


def main(arguments: argparse.Namespace) -> int:
    """1: the vehicle refused a value."""
    if arguments.action in ("set", "load", "reset"):
        with Link(arguments.link) as link:
            return _change(Vehicle(link, arguments.graph), arguments)
    with _source(arguments) as source:
        _show(source, arguments)
    return 0


@contextlib.contextmanager
def _source(arguments: argparse.Namespace) -> Iterator[Vehicle | Log]:
    if arguments.log is not None:
        yield Log(arguments.log, arguments.graph)
        return
    with Link(arguments.link) as link:
        yield Vehicle(link, arguments.graph)


# --- what there is ---


def _show(source: Vehicle | Log, arguments: argparse.Namespace) -> None:
    values = source.values()
    if arguments.action == "save":
        file.write(arguments.file, source.graph.name, source.table, values)
        facts = {"file": str(arguments.file.resolve()), "count": len(values)}
        text = f"saved {len(values)} parameters to {shown_path(arguments.file)}"
        print(json.dumps(facts, indent=2) if arguments.json else text)
        return
    rows = source.table
    if arguments.action == "get":
        rows = [find(rows, arguments.name)]
    elif arguments.changed:
        rows = [row for row in rows if values[row.id] != row.default]
    report = source.report() if isinstance(source, Vehicle) else None
    if arguments.json:
        params = [_facts(row, values[row.id]) for row in rows]
        print(json.dumps({"params": params, "store": _store_facts(report)}, indent=2))
        return
    for line in _lines(rows, values):
        print(line)
    if arguments.action == "list":
        print(_summary(source.table, values, report))


def _facts(row: Row, value: Value) -> dict[str, Any]:
    facts: dict[str, Any] = {"id": row.id, "name": row.name, "type": row.param.type, "value": value}
    bounds = [row.param.least, row.param.most]
    low, high = (None if bound is None else row.stored(bound) for bound in bounds)
    facts |= {"default": row.default, "unit": row.param.unit, "least": low, "most": high}
    return facts | {"in_flight": row.param.in_flight, "fixed": row.param.is_fixed}


def _store_facts(report: dict[str, Any] | None) -> dict[str, Any] | None:
    if report is None:
        return None
    facts = {key: report[key] for key in ("stored", "unknown", *COUNTS)}
    return {"state": STATES[report["state"]]} | facts


def _lines(rows: list[Row], values: dict[str, Value]) -> list[str]:
    cells = []
    for row in rows:
        mark = "*" if values[row.id] != row.default else " "
        default = f"(graph: {in_words(row.default)})" if mark == "*" else ""
        cells.append((f"{mark} {row.id}", row.shown(values[row.id]), default, row.name))
    widths = [max((len(cell[i]) for cell in cells), default=0) for i in range(3)]
    return [
        "  ".join(
            text.ljust(width) for text, width in zip(cell, (*widths, 0), strict=True)
        ).rstrip()
        for cell in cells
    ]


def _summary(table: list[Row], values: dict[str, Value], report: dict[str, Any] | None) -> str:
    changed = sum(values[row.id] != row.default for row in table)
    text = f"{len(table)} parameters, {changed} differ from the graph"
    if report is None:
        return text
    state = STATES[report["state"]]
    if state == "none":
        return f"{text}; no memory keeps them"
    if state != "loaded":
        return f"{text}; the memory {'is being read' if state == 'loading' else 'has failed'}"
    texts = [text, f"{report['stored']} kept"]
    texts += [f"{report[key]} {words}" for key, words in COUNTS.items() if report[key]]
    unused = [table[place - 1].id for place in report["unused"] if place]
    if unused:
        texts.append(f"not used: {', '.join(unused)}")
    if report["unknown"]:
        texts.append(f"{report['unknown']} records of parameters that this graph does not have")
    return "; ".join(texts)


# --- changes ---


def _change(vehicle: Vehicle, arguments: argparse.Namespace) -> int:
    before = vehicle.values()
    skipped: list[str] = []
    if arguments.action == "set":
        row = find(vehicle.table, arguments.name)
        wanted = {row.id: read_text(row, arguments.value)}
    elif arguments.action == "load":
        system = before.get(file.SYSTEM_ID, file.VEHICLE)
        loaded = file.read(arguments.file, vehicle.table, int(system))
        wanted, skipped = loaded.values, _skipped(loaded)
    else:
        rows = [find(vehicle.table, name) for name in arguments.names] or vehicle.table
        wanted = {row.id: row.default for row in rows}
    if arguments.action != "set":
        wanted = {name: value for name, value in wanted.items() if value != before[name]}
        if wanted and vehicle.is_armed():
            raise UserError(
                f"error: cannot {arguments.action} parameters: the vehicle is armed\n"
                "hint: disarm it, or set single ones: ./stator param set NAME VALUE"
            )
    by_id = {row.id: row for row in vehicle.table}
    changes = []
    for name, value in wanted.items():
        written = vehicle.set(by_id[name], value)
        changes.append((by_id[name], before[name], value, written.result))
    report = vehicle.kept() if changes else vehicle.report()
    refused = [change for change in changes if change[3] != "written"]
    if arguments.json:
        print(json.dumps(_change_facts(changes, skipped, report), indent=2))
    else:
        _tell(changes, skipped, report)
    return ANSWER_IS_NO if refused else 0


def _skipped(loaded: file.Loaded) -> list[str]:
    texts = []
    if loaded.unknown:
        texts.append(f"skipped {len(loaded.unknown)} unknown: {', '.join(loaded.unknown)}")
    if loaded.other_type:
        texts.append(
            f"skipped {len(loaded.other_type)} of another type: {', '.join(loaded.other_type)}"
        )
    return texts


Change = tuple[Row, Value, Value, str]


def _change_facts(
    changes: list[Change], skipped: list[str], report: dict[str, Any] | None
) -> dict[str, Any]:
    rows = [
        {"id": row.id, "name": row.name, "before": before, "value": value, "result": result}
        for row, before, value, result in changes
    ]
    return {"changes": rows, "skipped": skipped, "store": _store_facts(report)}


def _tell(changes: list[Change], skipped: list[str], report: dict[str, Any] | None) -> None:
    for row, before, value, result in changes:
        if result == "written":
            print(f"{row.id} = {row.shown(value)} (was {in_words(before)})")
            continue
        why, hint = WHY.get(
            result, (f"the vehicle refused it ({result})", "see ./stator param list")
        )
        print(f"error: cannot set {row.id}: {why}\nhint: {hint}", file=sys.stderr)
    for text in skipped:
        print(text)
    written = sum(change[3] == "written" for change in changes)
    if not changes:
        print("nothing to change")
    elif written:
        print(_kept_text(report))


def _kept_text(report: dict[str, Any] | None) -> str:
    if report is None or STATES[report["state"]] == "none":
        return "until the restart: no memory keeps parameters"
    if report["pending"] or report["refused"] or STATES[report["state"]] != "loaded":
        return "until the restart: the memory has not taken it; see ./stator param list"
    return "kept"
