"""Whatever a mission file holds, it is read or refused with a message, never with a traceback."""

from __future__ import annotations

import copy
import json
import tempfile
from pathlib import Path
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from stator.diagnostics import Failed, UserError
from stator.mission.read import read_mission
from stator.mission.route import seconds_of
from stator.mission.store import write
from stator.mission.vehicle import Vehicle

PLANS = sorted((Path(__file__).parent / "plans").iterdir())
VEHICLE = Vehicle(fence_radius=500.0, fence_height=120.0, farthest=1000.0)
ODD = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.integers(0, 300),
    st.floats(),
    st.text(max_size=8),
    st.just([]),
    st.just({}),
    st.just([0, 0]),
    st.just(10**400),
    st.lists(st.floats(-200, 200), max_size=8),
)


def read(content: bytes) -> None:
    """What is read can be stored and timed as well."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "mission"
        file.write_bytes(content)
        try:
            mission = read_mission(file, VEHICLE)
        except (UserError, Failed):
            return
        write(mission, file)
        assert seconds_of(mission, VEHICLE) > 0.0


def places_in(tree: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """The path to each value of a JSON tree."""
    inner = tree.items() if isinstance(tree, dict) else enumerate(tree)
    paths = []
    for key, value in inner:
        paths.append((*path, key))
        if isinstance(value, dict | list):
            paths += places_in(value, (*path, key))
    return paths


JSON_PLANS = [json.loads(p.read_bytes()) for p in PLANS if p.suffix != ".waypoints"]


@settings(max_examples=400, deadline=None, derandomize=True)
@given(st.data())
def test_any_value_at_any_place_of_a_plan(data: st.DataObject) -> None:
    plan = copy.deepcopy(data.draw(st.sampled_from(JSON_PLANS)))
    for _ in range(data.draw(st.integers(1, 3))):
        path = data.draw(st.sampled_from(places_in(plan)))
        inner = plan
        for key in path[:-1]:
            inner = inner[key]
        inner[path[-1]] = data.draw(ODD)
    read(json.dumps(plan).encode())


@settings(max_examples=200, deadline=None, derandomize=True)
@given(st.data())
def test_any_bytes_in_any_file(data: st.DataObject) -> None:
    content = bytearray(data.draw(st.sampled_from(PLANS)).read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(content)))
        content[at : at + data.draw(st.integers(0, 6))] = data.draw(st.binary(max_size=6))
    read(bytes(content))


@settings(max_examples=200, deadline=None, derandomize=True)
@given(
    st.lists(
        st.lists(
            st.one_of(
                st.floats(-200, 200),
                st.integers(0, 300),
                st.sampled_from(["nan", "inf", "-", "1e99"]),
            ),
            min_size=11,
            max_size=13,
        ),
        max_size=6,
    )
)
def test_any_numbers_in_waypoints(rows: list[list[Any]]) -> None:
    lines = ["QGC WPL 110", *(" ".join(map(str, row)) for row in rows)]
    read("\n".join(lines).encode())


@settings(max_examples=100, deadline=None, derandomize=True)
@given(st.binary(max_size=60))
def test_any_bytes(content: bytes) -> None:
    for start in (b"", b"{", b"QGC WPL 110\n", b"\xef\xbb\xbf"):
        read(start + content)
