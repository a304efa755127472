"""Reads the failsafe table of an app: mode x event x (in the air, on the ground). In the air a cell
is the mode that follows; on the ground it may only disarm. Proves four things: both halves are
total; the transitions form no cycle; no set of events ends in a mode that lacks what it needs; and
on the ground nothing leads to another mode, so that no failsafe can start a flight.

A parameter can choose another mode in a column. All that holds with each of its values: a cycle is
looked for among the transitions of all values together, and a mode lasts under a set of events only
where it goes on under each, so that each event counts for itself."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stator.graph.model import Failsafe, FailsafeChoice
from stator.language.nested import Key, Listing, Struct, Table
from stator.language.shapes import NAME_PATTERN, Integer, Leaf, Record, Text, items, quoted

if TYPE_CHECKING:
    from collections.abc import Iterator, Set
    from pathlib import Path

    from stator.diagnostics import Mark, Report
    from stator.graph.model import Message
    from stator.graph.sources import Sources

    Cells = dict[str, dict[str, Leaf]]  # mode -> event -> the mode that follows, or GO_ON

GO_ON = "go_on"
DISARM = "disarm"
HEADER = "event"  # the row of the table that names its columns
# The message whose enumerations name the modes and the events, and its two fields.
STATUS, MODES, EVENTS = "VehicleStatus", "nav_state", "failsafe_event"

_WORD = Text(NAME_PATTERN, "a name of lower case letters, digits and underscores")
_WORDS = Listing(_WORD)
_CHOICE = Struct(
    {
        "value": Key(Integer(), "The value of the parameter.", required=True),
        "instead": Key(
            Table(Table(_WORD, "a mode", NAME_PATTERN), "an event", NAME_PATTERN),
            "For each event, a mode of its column and the one that follows in its place, or go_on.",
        ),
    }
)
SHAPE = Struct(
    {
        "events": Key(
            Table(
                Struct({"without": Key(_WORDS, "The resources that the event takes away.")}),
                "an event",
                NAME_PATTERN,
            ),
            "The events, the most urgent first.",
            required=True,
        ),
        "needs": Key(
            Table(_WORDS, "a mode", NAME_PATTERN),
            "The resources that each mode needs.",
            required=True,
        ),
        "table": Key(
            Table(_WORDS, "a mode", NAME_PATTERN),
            "For each mode a row, for each event a column: the next mode; go_on keeps the mode. "
            "The row `event` names the columns.",
            required=True,
        ),
        "choices": Key(
            Table(
                Table(_CHOICE, "a choice", NAME_PATTERN),
                "a parameter",
                NAME_PATTERN,
            ),
            "For each parameter, the values with which an event leads to other modes than in the "
            "table. With any other value it is as in the table.",
        ),
        "landed": Key(
            Table(_WORDS, "a mode", NAME_PATTERN),
            "The same table for a vehicle on the ground, which an event may only disarm: each cell "
            "is disarm or go_on.",
            required=True,
        ),
    }
)


def read_failsafe(
    sources: Sources, path: Path, status: Message, params: Set[str]
) -> Failsafe | None:
    """The table; None after reporting what is wrong. `params`: whole numbers of the app."""
    report = sources.report
    count = len(report)
    record = sources.read(path, SHAPE)
    if record is None or len(report) > count:
        return None
    modes, events = _values(status, MODES), _values(status, EVENTS)[1:]
    _check_events(record, events, report)
    _check_keys(record.get("needs"), "needs", modes, "mode", report)
    cells = _cells(record, "table", (*modes, GO_ON), modes, events, report)
    landed = _cells(record, "landed", (DISARM, GO_ON), modes, events, report)
    _check_choices(record, modes, events, params, report)
    if len(report) > count:
        return None
    _check_circles(record, cells, modes, report)
    if len(report) == count:
        _check_needs(record, cells, report)
        _check_landed_needs(record, landed, report)
    if len(report) > count:
        return None
    return Failsafe(
        path,
        modes,
        events,
        tuple(tuple(_next(cells, m, e) for e in events) for m in modes),
        tuple(tuple(landed[m][e].value == DISARM for e in events) for m in modes),
        {mode: frozenset(words) for mode, words in _needs(record).items()},
        tuple(
            FailsafeChoice(param, value, event, tuple((k, v.value) for k, v in modes.items()))
            for param, value, event, modes in _choices(record)
        ),
    )


def _values(status: Message, field: str) -> tuple[str, ...]:
    found = next((f.values for f in status.fields if f.name == field), ())
    return tuple(name for name, _ in found)


def _check_events(record: Record, events: tuple[str, ...], report: Report) -> None:
    table = record.get("events")
    _check_keys(table, "events", events, "event", report)
    if set(table.keys) == set(events) and tuple(table.keys) != events:
        report.error(
            record.keys["events"],
            "failsafe-total",
            f"expected the events in the order of {STATUS}.{EVENTS}, the most urgent first",
            "write them in this order: " + ", ".join(events),
        )


def _check_keys(
    table: Record, name: str, known: tuple[str, ...], what: str, report: Report
) -> None:
    field = MODES if what == "mode" else EVENTS
    for key, mark in table.keys.items():
        if key not in known:
            hint = report.nearest(key, known)
            report.error(
                mark, "failsafe-total", f"unknown {what} '{key}' of {STATUS}.{field}", hint
            )
    for key in known:
        if key not in table.keys:
            report.error(
                table.owner,
                "failsafe-total",
                f"missing row '{key}' in '{name}'",
                f"add a row for '{key}'",
            )


def _cells(
    record: Record,
    name: str,
    words: tuple[str, ...],
    modes: tuple[str, ...],
    events: tuple[str, ...],
    report: Report,
) -> Cells:
    """The cells of the table, each under its column; reports what is missing or unknown."""
    table: Record = record.get(name)
    header = table.get(HEADER)
    columns = () if header is None else tuple(leaf.value for leaf in header.value)
    if columns != events:
        report.error(
            table.keys.get(HEADER, table.owner),
            "failsafe-total",
            f"expected the columns {', '.join(events)}; found {', '.join(columns) or 'none'}",
            f"write {HEADER}: [{', '.join(events)}]",
        )
    rows = {key: value for key, value in table.values.items() if key != HEADER}
    marks = {key: mark for key, mark in table.keys.items() if key != HEADER}
    _check_keys(table._replace(keys=marks), name, modes, "mode", report)
    for mode, row in rows.items():
        _check_row(marks[mode], row.value, words, events, report)
    return {mode: dict(zip(events, row.value, strict=False)) for mode, row in rows.items()}


def _check_row(
    mark: Mark, row: list[Leaf], words: tuple[str, ...], events: tuple[str, ...], report: Report
) -> None:
    if len(row) != len(events):
        report.error(
            mark,
            "failsafe-total",
            f"expected {len(events)} cells, one for each event, found {len(row)}",
            f"the columns are {', '.join(events)}; write {GO_ON} where the mode stays",
        )
    for leaf in row:
        if leaf.value in words:
            continue
        if DISARM in words:
            report.error(
                leaf.mark,
                "failsafe-landed",
                f"expected {DISARM} or {GO_ON} on the ground, found {quoted(leaf.value)}",
                f"write {DISARM}: a failsafe that changes the mode could start a flight",
            )
            continue
        hint = report.nearest(leaf.value, words)
        report.error(leaf.mark, "failsafe-total", f"unknown mode {quoted(leaf.value)}", hint)


def _needs(record: Record) -> dict[str, set[str]]:
    return {m: {leaf.value for leaf in words.value} for m, words in items(record, "needs")}


def _takes(record: Record) -> dict[str, set[str]]:
    """What each event takes away."""
    takes: dict[str, set[str]] = {}
    for event, value in items(record, "events"):
        words = value.get("without")
        takes[event] = set() if words is None else {leaf.value for leaf in words.value}
    return takes


def _check_landed_needs(record: Record, landed: Cells, report: Report) -> None:
    """On the ground no mode changes, so each event counts for itself."""
    needs = _needs(record)
    for event, taken in _takes(record).items():
        for mode, row in landed.items():
            missing = needs[mode] & taken
            if row[event].value != GO_ON or not missing:
                continue
            report.error(
                row[event].mark,
                "failsafe-needs",
                f"{mode} goes on on the ground, needs {', '.join(sorted(missing))}, and {event} "
                "takes it away",
                f"write {DISARM}",
            )


def _choices(record: Record) -> Iterator[tuple[str, int, str, dict[str, Leaf]]]:
    """Parameter, value, event, and for modes of its column the word that counts in their place."""
    for param, choices in items(record, "choices"):
        for choice in choices.values.values():
            for event, instead in items(choice, "instead"):
                yield param, choice.get("value").value, event, instead.values


def _check_choices(
    record: Record,
    modes: tuple[str, ...],
    events: tuple[str, ...],
    params: Set[str],
    report: Report,
) -> None:
    table = record.get("choices")
    chosen: dict[str, str] = {}  # event -> parameter
    for param, choices in items(record, "choices"):
        if param not in params:
            report.error(
                table.keys[param],
                "failsafe-choice",
                f"expected an int32 parameter of the app, found {quoted(param)}",
                report.nearest(param, sorted(params)),
            )
        values: dict[int, str] = {}
        for name, choice in choices.values.items():
            value = choice.get("value").value
            if value in values:
                report.error(
                    choices.keys[name],
                    "failsafe-choice",
                    f"expected a value of its own, found {value} of '{values[value]}'",
                    "write another value",
                )
            values[value] = name
            for event, instead in items(choice, "instead"):
                mark = choice.get("instead").keys[event]
                if event not in events:
                    hint = report.nearest(event, events)
                    report.error(mark, "failsafe-total", f"unknown event '{event}'", hint)
                if chosen.setdefault(event, param) != param:
                    report.error(
                        mark,
                        "failsafe-choice",
                        f"'{chosen[event]}' chooses about {event} already",
                        "use one parameter for each event",
                    )
                for mode, leaf in instead.values.items():
                    for word, at in ((mode, instead.keys[mode]), (leaf.value, leaf.mark)):
                        if word in modes or (word == GO_ON and word is leaf.value):
                            continue
                        hint = report.nearest(word, modes)
                        report.error(at, "failsafe-total", f"unknown mode {quoted(word)}", hint)


def _next(cells: Cells, mode: str, event: str) -> str:
    into: str = cells[mode][event].value
    return mode if into == GO_ON else into


def _variants(record: Record, cells: Cells) -> Iterator[tuple[str, str, Leaf]]:
    """Mode, event, and what follows: as in the table, and as with each value of a parameter."""
    for mode, row in cells.items():
        for event, leaf in row.items():
            yield mode, event, leaf
            for _, _, chosen, instead in _choices(record):
                if chosen == event and leaf.value in instead:
                    yield mode, event, instead[leaf.value]


def _goes_on(mode: str, leaf: Leaf) -> bool:
    return leaf.value in (GO_ON, mode)


def _check_circles(record: Record, cells: Cells, modes: tuple[str, ...], report: Report) -> None:
    """No sequence of events comes back to a mode that it has left."""
    ways: dict[str, dict[str, Mark]] = {mode: {} for mode in modes}  # to, and where it is written
    for mode, _, leaf in _variants(record, cells):
        if not _goes_on(mode, leaf):
            ways[mode].setdefault(leaf.value, leaf.mark)
    done: set[str] = set()
    for first in modes:
        _walk(first, [], done, ways, report)


def _walk(
    mode: str, path: list[str], done: set[str], ways: dict[str, dict[str, Mark]], report: Report
) -> None:
    if mode in path:
        circle = " -> ".join([*path[path.index(mode) :], mode])
        report.error(
            ways[path[-1]][mode],
            "failsafe-circle",
            f"failsafe transitions form a cycle: {circle}",
            "write go_on here, or a mode that does not lead back",
        )
        return
    if mode in done:
        return
    path.append(mode)
    for following in ways[mode]:
        _walk(following, path, done, ways, report)
    path.pop()
    done.add(mode)


def _check_needs(record: Record, cells: Cells, report: Report) -> None:
    """Every mode that the table ends in has what it needs."""
    needs, takes = _needs(record), _takes(record)
    for mode, event, leaf in _variants(record, cells):
        missing = needs[mode] & takes[event]
        if not missing or not _goes_on(mode, leaf):
            continue
        report.error(
            leaf.mark,
            "failsafe-needs",
            f"the table ends in {mode}, which needs {', '.join(sorted(missing))}, and {event} "
            "takes it away",
            f"write a mode that does not need {', '.join(sorted(missing))}",
        )
