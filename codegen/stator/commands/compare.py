"""`./stator compare`: what differs between flights, and all in one picture."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stator.arguments import path
from stator.charts.differences import FIGURES, LETTERS, compare, side
from stator.diagnostics import UserError, shown_path
from stator.flight.plot import FORMATS, check_format

if TYPE_CHECKING:
    import argparse

MAX_ROWS = 20


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("a", type=path, metavar="A", help="ULog file of the first flight")
    parser.add_argument("b", type=path, metavar="B", help="ULog file of the second flight")
    parser.add_argument(
        "more", type=path, nargs="*", metavar="MORE", help="of further flights, such as of a sweep"
    )
    parser.add_argument(
        "--topic",
        action="append",
        default=[],
        metavar="TOPIC[.FIELD]",
        help="draw this of all over time, instead of the flights; use it once for each panel",
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
    logs = [arguments.a, arguments.b, *arguments.more]
    if len(logs) > len(LETTERS):
        raise UserError(
            f"error: expected at most {len(LETTERS)} logs, found {len(logs)}\n"
            "hint: --json of each flight has its figures, for a table of one's own"
        )
    others = logs[1].stem if len(logs) == 2 else f"{len(logs) - 1}-others"
    output: Path = arguments.output or logs[1].with_name(f"{logs[0].stem}-vs-{others}.png")
    check_format(output)
    facts = compare([side(log) for log in logs])
    facts |= _picture(logs, arguments.topic, output, facts)
    if arguments.json:
        print(json.dumps(facts, indent=2))
    else:
        _report(logs, facts)
    return 0


def _picture(
    logs: list[Path], topics: list[str], output: Path, facts: dict[str, Any]
) -> dict[str, object]:
    from stator.charts.overlay import draw_overlay
    from stator.charts.topics import draw_topics

    if topics:
        draw_topics(logs, topics, output)
        return {"picture": str(output.resolve())}
    title = "    ".join(f"{letter}: {log.stem}" for letter, log in zip(LETTERS, logs, strict=False))
    texts = [f"{row['name']} {_change(row['values'])}" for row in facts["params"][:3]]
    if texts:
        title += "\n" + ", ".join(texts) + (", ..." if len(facts["params"]) > 3 else "")
    try:
        draw_overlay(logs, output, title)
    except UserError as error:  # flights without a path, such as of one node
        return {"picture": None, "no_picture": str(error).splitlines()[0].removeprefix("error: ")}
    return {"picture": str(output.resolve())}


# --- for people ---


def _report(logs: list[Path], facts: dict[str, Any]) -> None:
    letters = LETTERS[: len(logs)]
    for i, (letter, log) in enumerate(zip(letters, logs, strict=True)):
        print(f"{letter}  {shown_path(log)}: {_outcome(facts, i)}")
    if facts["identical"]:
        print("the logs are identical, byte for byte")
    elif facts["figures"]:
        last = f"{'B - A':>12}" if len(logs) == 2 else ""
        print(f"\n  {'':<26}{''.join(f'{letter:>12}' for letter in letters)}{last}")
        for row in facts["figures"]:
            print(_figure(row, has_difference=bool(last)))
    _section("settings", [f"{r['name']}: {_change(r['values'])}" for r in facts["settings"]])
    _section("parameters", [f"{r['name']}: {_change(r['values'])}" for r in facts["params"]])
    _section("graph", _graph_lines(facts))
    print()
    if facts["picture"] is None:
        print(f"no picture: {facts['no_picture']}")
    else:
        print(f"{shown_path(Path(facts['picture']))}: written")


def _figure(row: dict[str, Any], *, has_difference: bool) -> str:
    name, unit = FIGURES[row["key"]]
    numbers = "".join(f"{_number(value):>12}" for value in row["values"])
    if not has_difference:
        return f"  {name:<26}{numbers} {unit}".rstrip()
    change = "" if not row["difference"] else f"{row['difference']:+.4g}"
    return f"  {name:<26}{numbers}{change:>12} {unit if change else ''}".rstrip()


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
    if len(set(facts["graph_hash"])) == 1:
        return []
    lines = [f"other hash: {_change([text[:12] or 'none' for text in facts['graph_hash']])}"]
    if len(set(facts["graph"])) > 1:
        lines.insert(0, f"name: {_change(facts['graph'])}")
    return lines + [
        f"{row['what']}: {'differs' if row['how'] == 'other' else row['how']}"
        for row in facts["graph_differences"]
    ]


def _outcome(facts: dict[str, Any], number: int) -> str:
    success = facts["success"][number]
    if success is None:
        return "no report beside the log"
    return f"{'success' if success else 'FAILED'}; {facts['reason'][number]}"


def _change(values: list[Any]) -> str:
    return " -> ".join(_number(value) for value in values)


def _number(value: Any) -> str:
    if value is None:
        return "none"
    if isinstance(value, list):
        return ", ".join(map(str, value)) or "none"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
