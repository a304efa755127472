"""A device stands in board.yaml only: what is generated of it for board code and world."""

from __future__ import annotations

from pathlib import Path

from stator.emit.emit import emit
from stator.graph.check import check
from stator.plan.plan import plan

ROOT = Path(__file__).resolve().parents[3]


def generated(graph: str, board: str | None = None) -> dict[str, str]:
    return emit(plan(*check(ROOT / graph, board)))


def test_a_device_is_declared_and_defined_with_its_lines() -> None:
    files = generated("tests/boards/world/graphs/new_sensor.yaml")
    name = "drivers::range::sim::RangeSim::Device range0;\n"
    assert '#include "drivers/range/sim/range_sim.hpp"\n' in files["devices.hpp"]
    assert f"extern {name}extern Line range0_data_ready;\n" in files["devices.hpp"]
    assert f"\n{name}Line range0_data_ready;\n" in files["devices.cpp"]


def test_the_world_feeds_what_has_a_part_in_it() -> None:
    files = generated("tests/boards/world/graphs/new_sensor.yaml")
    assert (
        "keep(range0_faults_.spoil(range0_.measure(world), world), samples.range0);"
        in files["sensors.hpp"]
    )
    assert "give(range0, samples.range0.sample, range0_data_ready);" in files["hand_over.hpp"]
    assert "give(range1, samples.range1.sample);" in files["hand_over.hpp"]
    sitl = generated("graph/quad.yaml", "sitl")
    assert "motors" in sitl["devices.hpp"]
    assert "motors" not in sitl["sensors.hpp"] + sitl["hand_over.hpp"] + sitl["samples.hpp"]


def test_lines_of_bare_metal_are_vectors_that_the_board_pends() -> None:
    files = generated("graph/quad.yaml", "qemu_f405")
    assert "Line " not in files["devices.hpp"]
    assert "give(imu0, samples.imu0.sample, lines::imu0_data_ready);" in files["hand_over.hpp"]
    assert "bool take_imu0_data_ready() {\n    return true;\n}" in files["devices.cpp"]


def test_a_board_without_the_world_has_devices_only() -> None:
    files = generated("graph/quad.yaml", "fmu_v2")
    assert "CanBxcan::Device can1;" in files["devices.cpp"]
    assert "take_" not in files["devices.cpp"]
    assert not {"samples.hpp", "sensors.hpp", "hand_over.hpp"} & set(files)
