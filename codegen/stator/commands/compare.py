"""`./stator compare`: what differs between two flights, and both in one picture."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stator.arguments import path
from stator.charts.differences import FIGURES, compare, side
from stator.diagnostics import UserError, shown_path
from stator.flight.plot import FORMATS, check_format

if TYPE_CHECKING:
    import argparse

MAX_ROWS = 20


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("a", type=path, metavar="A", help="ULog file of the first flight")
    parser.add_argument("b", type=path, metavar="B", help="ULog file of the second flight")
    parser.add_argument(
        "--topic",
        action="append",
        default=[],
        metavar="TOPIC[.FIELD]",
        help="draw this of both over time, instead of the flights; use it once for each panel",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=path,
        metavar="FILE",
        help=f"picture to write: {', '.join(FORMATS)} (default: A-vs-B.png beside B)",
    )
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def main(arguments: argparse.Namespace) -> int:
    """0, whatever differs."""
    logs = [arguments.a, arguments.b]
    output: Path = arguments.output or arguments.b.with_name(
        f"{arguments.a.stem}-vs-{arguments.b.stem}.png"
    )
    check_format(output)
    facts = compare(side(arguments.a), side(arguments.b))
    facts |= _picture(logs, arguments.topic, output, facts)
    if arguments.json:
        print(json.dumps(facts, indent=2))
    else:
        _report(arguments, facts)
    return 0


def _picture(
    logs: list[Path], topics: list[str], output: Path, facts: dict[str, Any]
) -> dict[str, object]:
    from stator.charts.overlay import draw_overlay
    from stator.charts.topics import draw_topics

    if topics:
        draw_topics(logs, topics, output)
        return {"picture": str(output.resolve())}
    title = f"A: {logs[0].stem}    B: {logs[1].stem}"
    texts = [f"{row['name']} {_pair(row['values'])}" for row in facts["params"][:3]]
    if texts:
        title += "\n" + ", ".join(texts) + (", ..." if len(facts["params"]) > 3 else "")
    try:
        draw_overlay(logs, output, title)
    except UserError as error:  # flights without a path, such as of one node
        return {"picture": None, "no_picture": str(error).splitlines()[0].removeprefix("error: ")}
    return {"picture": str(output.resolve())}


# --- for people ---


def _report(arguments: argparse.Namespace, facts: dict[str, Any]) -> None:
    print(f"A  {shown_path(arguments.a)}: {_outcome(facts, 0)}")
    print(f"B  {shown_path(arguments.b)}: {_outcome(facts, 1)}")
    if facts["identical"]:
        print("the logs are identical, byte for byte")
    elif facts["figures"]:
        print(f"\n  {'':<26}{'A':>12}{'B':>12}{'B - A':>12}")
        for row in facts["figures"]:
            name, unit = FIGURES[row["key"]]
            numbers = "".join(f"{_number(value):>12}" for value in row["values"])
            change = "" if not row["difference"] else f"{row['difference']:+.4g}"
            print(f"  {name:<26}{numbers}{change:>12} {unit if change else ''}".rstrip())
    _section("settings", [f"{r['name']}: {_pair(r['values'])}" for r in facts["settings"]])
    _section("parameters", [f"{r['name']}: {_pair(r['values'])}" for r in facts["params"]])
    _section("graph", _graph_lines(facts))
    print()
    if facts["picture"] is None:
        print(f"no picture: {facts['no_picture']}")
    else:
        print(f"{shown_path(Path(facts['picture']))}: written")


def _section(title: str, lines: list[str]) -> None:
    if not lines:
        print(f"\n{title}: equal")
        return
    print(f"\n{title} that differ" if title != "graph" else "\ngraph")
    for line in lines[:MAX_ROWS]:
        print(f"  {line}")
    if len(lines) > MAX_ROWS:
        print(f"  and {len(lines) - MAX_ROWS} more; --json has them all")


def _graph_lines(facts: dict[str, Any]) -> list[str]:
    if facts["graph_hash"][0] == facts["graph_hash"][1]:
        return []
    lines = [f"other hash: {_pair([text[:12] or 'none' for text in facts['graph_hash']])}"]
    if facts["graph"][0] != facts["graph"][1]:
        lines.insert(0, f"name: {_pair(facts['graph'])}")
    ways = {"other": "differs", "only in A": "only in A", "only in B": "only in B"}
    return lines + [f"{row['what']}: {ways[row['how']]}" for row in facts["graph_differences"]]


def _outcome(facts: dict[str, Any], number: int) -> str:
    success = facts["success"][number]
    if success is None:
        return "no report beside the log"
    return f"{'success' if success else 'FAILED'}; {facts['reason'][number]}"


def _pair(values: list[Any]) -> str:
    return " -> ".join(_number(value) for value in values)


def _number(value: Any) -> str:
    if value is None:
        return "none"
    if isinstance(value, list):
        return ", ".join(map(str, value)) or "none"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
