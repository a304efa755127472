"""`--param`: another value for one flight, checked as the graph is, without a build."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest
from pyulog import ULog

from stator import HOME
from stator import __main__ as cli
from stator.diagnostics import UserError
from stator.flight.params import read_params, with_params
from stator.graph.model import Graph
from stator.mission.vehicle import vehicle_of
from stator.pipeline import make_plan


def graph_of(name: str = "quad") -> Graph:
    return make_plan(str(HOME / "graph" / f"{name}.yaml"), "sitl").graph


@pytest.mark.parametrize(
    ("text", "option"),
    [
        ("rate_control.roll_p=0.1", "rate_control.roll_p=0.1"),  # s/rad, which has no other unit
        ("rate_control.roll_p=0.1 s/rad", "rate_control.roll_p=0.1"),
        ("rate_control.roll_p=1e-20", "rate_control.roll_p=1e-20"),
        ("attitude.mag_time_constant=12000 ms", "attitude.mag_time_constant=12.0"),
        ("attitude_control.roll_rate_limit=180 deg/s", "attitude_control.roll_rate_limit=3.14159"),
        ("allocation.airmode=true", "allocation.airmode=true"),
        ("allocation.rotor_count=6", "allocation.rotor_count=6"),
        ("CA_ROTOR_COUNT=6", "allocation.rotor_count=6"),  # its id
    ],
)
def test_values_are_read_in_their_units(text: str, option: str) -> None:
    (row,) = read_params(graph_of(), [text])
    assert row.option.startswith(option)


@pytest.mark.parametrize(
    ("text", "what", "hint"),
    [
        ("roll_p=1", "expected NODE.PARAMETER=VALUE", "rate_control.roll_p=0.1"),
        ("rate_control.roll_p", "expected NODE.PARAMETER=VALUE", "rate_control.roll_p=0.1"),
        ("rate_control.rol_p=1", "unknown parameter 'rol_p' of 'rate_control'", "'roll_p'?"),
        ("rate_contrl.roll_p=1", "unknown node 'rate_contrl' of quad", "'rate_control.roll_p'?"),
        ("logger.x=1", "unknown parameter 'x' of 'logger', which has none", "another node"),
        ("rate_control.roll_p=30", "expected a value from 0 to 5 s/rad", "write 5 s/rad or less"),
        ("rate_control.roll_p=1 m", "expected a value in s/rad", "use s/rad"),
        ("attitude.mag_time_constant=12", "expected a number with its unit", "write 12 s or"),
        ("allocation.airmode=1", "expected true or false", "true or false"),
        ("rate_control.roll_p=", "expected a number for 'roll_p'", "write a number"),
    ],
)
def test_what_the_graph_refuses_is_refused(text: str, what: str, hint: str) -> None:
    with pytest.raises(UserError) as caught:
        read_params(graph_of(), [text])
    first, second = str(caught.value).split("\n")
    assert first.startswith(f"error: --param '{text}': {what}")
    assert second.startswith("hint: ")
    assert hint in second


def test_all_errors_are_said_at_once_and_one_parameter_has_one_value() -> None:
    twice = "rate_control.roll_p=0.2"
    with pytest.raises(UserError) as caught:
        read_params(graph_of(), ["a.b=1", twice, twice])
    text = str(caught.value)
    assert "unknown node 'a'" in text
    assert "given twice" in text


def test_a_value_that_the_graph_has_already_replaces_nothing() -> None:
    assert read_params(graph_of(), ["rate_control.roll_p=0.22"]) == []


def test_a_mission_is_checked_with_the_values_that_fly() -> None:
    graph = graph_of("quad_outdoor")
    flown = with_params(graph, read_params(graph, ["navigator.fence_radius=25 m"]))
    assert vehicle_of(flown).fence_radius == 25.0
    assert vehicle_of(graph).fence_radius != 25.0


def fly(log: Path, *arguments: str) -> dict[str, Any]:
    command = [HOME / "stator", "fly", "--duration", "3", "--json", "-o", log, *arguments]
    finished = subprocess.run(command, check=False, capture_output=True, text=True)
    assert finished.stdout, finished.stderr
    facts: dict[str, Any] = json.loads(finished.stdout)
    return facts


def test_a_flight_has_the_values_and_its_replay_too(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    plain = fly(tmp_path / "plain.ulg")
    program = HOME / "build" / "quad-sitl-STATOR_RECORDING" / "graph_program"
    built_ns = program.stat().st_mtime_ns
    facts = fly(
        tmp_path / "other.ulg",
        "--param=rate_control.roll_p=0.1",
        "--param=allocation.airmode=true",
        "--param=allocation.rotor_count=4",  # as the graph has it
    )
    assert program.stat().st_mtime_ns == built_ns
    assert plain["params"] == []
    assert facts["params"] == [
        {"name": "rate_control.roll_p", "value": 0.1, "graph_value": 0.22, "unit": "s/rad"},
        {"name": "allocation.airmode", "value": True, "graph_value": False, "unit": "1"},
    ]
    assert facts["log_sha256"] != plain["log_sha256"]

    log = ULog(str(tmp_path / "other.ulg"))
    assert log.initial_parameters["rate_control.roll_p"] == pytest.approx(0.1)
    assert log.initial_parameters["allocation.airmode"] == 1
    graph_values = log.get_default_parameters(1)
    assert graph_values.keys() == {"rate_control.roll_p", "allocation.airmode"}
    assert graph_values["rate_control.roll_p"] == pytest.approx(0.22)
    assert ULog(str(tmp_path / "plain.ulg")).get_default_parameters(1) == {}

    capsys.readouterr()
    assert cli.main(["replay", str(tmp_path / "other.ulg"), "--json"]) == 0
    replayed = json.loads(capsys.readouterr().out)
    assert replayed["equal"]
    assert replayed["topics"]["rate_control_params"]
    assert [row["name"] for row in replayed["params"]] == [
        "rate_control.roll_p",
        "allocation.airmode",
    ]
