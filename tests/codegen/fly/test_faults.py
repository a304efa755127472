"""What --fail takes for a graph, and what it refuses."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from stator import HOME
from stator.diagnostics import UserError
from stator.flight.faults import Faults, read_faults, unseen
from stator.pipeline import make_plan

OUTDOOR = make_plan(str(HOME / "graph" / "quad_outdoor.yaml"), "sitl")
LAB = make_plan(str(HOME / "graph" / "quad.yaml"), "sitl")


def options(text: str) -> list[str]:
    return Faults(OUTDOOR).read(text).options()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("baro0.stuck@20+5", ["baro0.stuck@20.000000+5.000000"]),
        ("imu0.accel_z_offset=9.8@25+1", ["imu0.accel_z_offset=9.8@25.000000+1.000000"]),
        ("gnss_loss@20", ["gnss_loss@20.000000"]),
        ("gnss0.loss@20", ["gnss_loss@20.000000"]),
        ("motor_2=0.9@10", ["motor_2.partial=0.9@10.000000"]),
        ("motor_2.stuck@10", ["motor_2.motor_stuck@10.000000"]),
        (
            "gnss0.spoof=1@9",
            ["gnss0.position_x_drift=1@9.000000", "gnss0.velocity_x_offset=1@9.000000"],
        ),
    ],
)
def test_what_the_flight_program_gets(text: str, expected: list[str]) -> None:
    assert options(text) == expected


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("foo.stuck@1", "unknown part 'foo'"),
        ("baro0.stuckk@1", "did you mean 'baro0.stuck'?"),
        ("baro0.stuck=1@1", "expected no value"),
        ("motor_1=2@1", "expected a value from 0 to 1"),
        ("baro0.stuck", "expected PART.FAULT"),
        ("random=0", "expected random=1 to random=8"),
    ],
)
def test_what_is_refused(text: str, message: str) -> None:
    with pytest.raises(UserError, match=message.replace("?", r"\?")):
        read_faults(OUTDOOR, [text], 1, 60.0)


def test_an_unknown_one_lists_what_the_graph_has() -> None:
    with pytest.raises(UserError) as refused:
        Faults(LAB).read("gnss0.loss@1")
    assert "mocap0: " in str(refused.value)
    assert "gnss0" not in str(refused.value).partition("this graph has")[2]


def test_random_ones_come_from_the_seed() -> None:
    drawn = [read_faults(OUTDOOR, ["random=3"], seed, 60.0) for seed in (1, 1, 2)]
    assert drawn[0] == drawn[1]
    assert drawn[0] != drawn[2]
    assert all(len(faults) == 3 and all(f.from_s <= 60.0 for f in faults) for faults in drawn)


def test_what_no_sensor_shows_is_named() -> None:
    faults = read_faults(OUTDOOR, ["gnss0.spoof@9", "baro0.stuck@9"], 1, 60.0)
    assert unseen(faults) == ["gnss0.spoof=0.5@9"]
    assert math.isinf(faults[0].lasts_s)


def test_the_simulated_world_knows_every_name() -> None:
    """The names of boards/world/faults.cpp are the ends of those here."""
    source = Path(HOME / "boards" / "world" / "faults.cpp").read_text(encoding="utf-8")
    known = [line.split('"')[1] for line in source.splitlines() if 'Row{"' in line]
    for part in Faults(OUTDOOR).classes:
        for name, usual in Faults(OUTDOOR).of_part(part).items():
            value = "" if usual.value is None else f"={usual.value}"
            for option in options(f"{part}.{name}{value}@1"):
                bare = option.partition("@")[0].partition("=")[0].rpartition(".")[2]
                assert any(bare.endswith(row) for row in known), option


def test_a_node_that_is_no_device_gets_stuck() -> None:
    assert options("rate_control.stuck@20+1") == ["rate_control.hang@20.000000+1.000000"]
    with pytest.raises(UserError, match="unknown fault 'loss' of rate_control"):
        Faults(OUTDOOR).read("rate_control.loss@20")


def test_random_faults_are_of_what_the_vehicle_has() -> None:
    known = Faults(OUTDOOR)
    drawn = [fault for seed in range(200) for fault in known.draw(3, seed, 60.0)]
    assert not any(fault.is_of_node for fault in drawn)
