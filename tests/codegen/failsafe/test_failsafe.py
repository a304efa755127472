"""The failsafe table of the commander, and the proof of such tables against a search of our own."""

from __future__ import annotations

import copy
import random
import re
from itertools import combinations
from pathlib import Path
from typing import Any

import pytest
import yaml

from stator import HOME
from stator.diagnostics import Mark, Report
from stator.graph.failsafe import read_failsafe
from stator.graph.messages import find_message
from stator.graph.sources import Sources

TABLE = HOME / "apps" / "commander" / "failsafe.yaml"
TABLES = ("table", "landed")  # in the air, and on the ground
URGENCY = [
    "crashed", "estimator_invalid", "position_lost", "motor_lost", "geofence", "battery_critical",
    "rc_lost", "station_lost", "offboard_lost", "cannot_follow", "mission_lost",
    "battery_low",
]  # fmt: skip
PARAMS = {
    "rc_loss_action", "station_loss_action", "offboard_loss_action", "low_battery_action",
    "fence_action",
}  # fmt: skip


def load() -> dict[str, Any]:
    """The file, with the tables as mode -> event -> mode."""
    content: dict[str, Any] = yaml.safe_load(TABLE.read_text(encoding="utf-8"))
    for name in TABLES:
        columns = content[name].pop("event")
        content[name] = {
            mode: dict(zip(columns, row, strict=True)) for mode, row in content[name].items()
        }
    return content


def read(content: dict[str, Any], folder: Path) -> bool:
    """Whether Stator takes the table, as load has it."""
    tables = {
        name: {
            "event": list(URGENCY),
            **{mode: list(row.values()) for mode, row in content[name].items()},
        }
        for name in TABLES
    }
    return read_rows({**content, **tables}, folder)


def read_rows(content: dict[str, Any], folder: Path) -> bool:
    """Whether Stator takes the file with this content."""
    file = folder / "failsafe.yaml"
    file.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
    sources = Sources(HOME, Report())
    status = find_message(sources, "VehicleStatus", Mark(HOME, 1, 1))
    assert status is not None
    return read_failsafe(sources, file, status, PARAMS) is not None


def next_modes(content: dict[str, Any], mode: str, event: str) -> set[str]:
    """As in the table, and with each value of a parameter."""
    cell = content["table"][mode][event]
    values = [value for values in content["choices"].values() for value in values.values()]
    columns = [value["instead"].get(event, {}) for value in values]
    cells = {cell, *(column.get(cell, cell) for column in columns)}
    return {mode if after == "go_on" else after for after in cells}


def is_sound(content: dict[str, Any]) -> bool:
    """By brute force: from any mode, whatever events come in whatever order, no mode comes back
    after it was left; and where a set of events lets a mode stay, it takes nothing that that needs.
    """
    modes = list(content["table"])
    reachable = {m: {n for e in URGENCY for n in next_modes(content, m, e)} - {m} for m in modes}
    for _ in modes:
        for m in modes:
            reachable[m] |= {far for near in reachable[m] for far in reachable[near]}
    if any(m in reachable[m] for m in modes):
        return False
    # A mode stays where each of the events lets it stay, so more than two at once show no more.
    sets = [set(c) for n in range(3) for c in combinations(URGENCY, n)]
    for mode in modes:
        for active in sets:
            if any(mode not in next_modes(content, mode, e) for e in active):
                continue
            takes = {w for e in active for w in content["events"][e].get("without", [])}
            if takes & set(content["needs"][mode]):
                return False
    return is_sound_on_the_ground(content)


def is_sound_on_the_ground(content: dict[str, Any]) -> bool:
    """Nothing but disarming changes anything, and what goes on has what it needs."""
    for mode, row in content["landed"].items():
        for event, cell in row.items():
            takes = set(content["events"][event].get("without", []))
            if cell not in ("disarm", "go_on"):
                return False
            if cell == "go_on" and takes & set(content["needs"][mode]):
                return False
    return True


def test_the_commanders_table_is_sound(tmp_path: Path) -> None:
    assert is_sound(load())
    assert read(load(), tmp_path)


def test_what_is_urgent_comes_first() -> None:
    assert list(load()["events"]) == URGENCY


@pytest.mark.parametrize("seed", range(5))
def test_agrees_with_brute_force_on_changed_tables(seed: int, tmp_path: Path) -> None:
    draw = random.Random(seed)
    modes = list(load()["table"])
    verdicts = []
    for _ in range(20):
        content = copy.deepcopy(load())
        for _ in range(draw.randrange(1, 3)):
            event = draw.choice(URGENCY)
            content["table"][draw.choice(modes)][event] = draw.choice([*modes, "go_on"])
            if draw.random() < 0.2:
                content["landed"][draw.choice(modes)][event] = draw.choice(["go_on", "disarm"])
        verdicts.append(is_sound(content))
        assert read(content, tmp_path) == verdicts[-1], content["table"]
    assert len(set(verdicts)) == 2  # both kinds were drawn


@pytest.mark.parametrize(
    ("param", "event", "instead"),
    [
        ("rc_loss_action", "rc_lost", {"return": "go_on"}),  # manual, without a pilot
        ("fence_action", "geofence", {"return": "mission"}),  # and a return to it: a circle
    ],
)
def test_every_choice_is_proven(
    param: str, event: str, instead: dict[str, str], tmp_path: Path
) -> None:
    content = load()
    content["choices"][param]["more"] = {"value": 9, "instead": {event: instead}}
    assert not is_sound(content)
    assert not read(content, tmp_path)


def test_on_the_ground_no_event_may_change_the_mode(tmp_path: Path) -> None:
    """Whatever the mode and the event: a return from the ground would be a take-off."""
    for mode in load()["table"]:
        content = load()
        content["landed"][mode]["rc_lost"] = "return"
        assert not read(content, tmp_path), mode


@pytest.mark.parametrize("part", ["events", "needs", "table", "landed"])
def test_nothing_may_be_left_out(part: str, tmp_path: Path) -> None:
    for key in load()[part]:
        content = load()
        del content[part][key]
        assert not read(content, tmp_path), key


def test_every_row_has_a_cell_for_every_event(tmp_path: Path) -> None:
    content = yaml.safe_load(TABLE.read_text(encoding="utf-8"))
    assert read_rows(content, tmp_path)
    for name in TABLES:
        for key in content[name]:
            for change in (lambda row: [*row, row[-1]], lambda row: row[:-1]):
                table = {**content[name], key: change(content[name][key])}
                assert not read_rows({**content, name: table}, tmp_path), key


def test_the_columns_are_named_in_the_order_of_urgency(tmp_path: Path) -> None:
    content = yaml.safe_load(TABLE.read_text(encoding="utf-8"))
    content["table"]["event"].reverse()
    assert not read_rows(content, tmp_path)
    del content["table"]["event"]
    assert not read_rows(content, tmp_path)


def test_the_table_is_aligned() -> None:
    """A person reads it as a table: each column starts in one place."""
    air, ground = TABLE.read_text(encoding="utf-8").split("\ntable:")[1].split("\nlanded:")
    for table in (air, ground):
        lines = table.splitlines()[1:]
        starts = [[m.start() for m in re.finditer(r"(?<=[\[ ])[a-z]", line[3:])] for line in lines]
        assert len(set(map(tuple, starts))) == 1
