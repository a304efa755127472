"""Ids of parameters: they depend on nothing but the parameter's own name or `id`."""

from __future__ import annotations

import zlib
from pathlib import Path

import pytest

from stator import HOME
from stator.graph.model import Param
from stator.graph.param_ids import definition_of, former_keys_of, id_of, key_of
from stator.pipeline import make_plan

GRAPHS = sorted(path for path in (HOME / "graph").glob("*.yaml") if path.stem.startswith("quad"))


def param(
    name: str = "gain", kind: str = "float", unit: str = "1", own: str = "", *was: str
) -> Param:
    return Param(name, kind, unit, None, None, 0, "A gain.", id=own, was=was)


def test_a_derived_id_has_letters_of_both_names_and_digits_of_their_checksum() -> None:
    assert zlib.crc32(b"rate_control.roll_p") == 0x6FCA5F8E  # 01101 11111 00101 00101 ...
    assert id_of("rate_control", param("roll_p")) == "RATE_ROLLP_N7FF"
    assert id_of("a", param("b")).startswith("A_B_")
    assert id_of("position_control", param("horizontal_velocity_p")).startswith("POSI_HORIZO_")


def test_a_given_id_has_the_number_of_its_node() -> None:
    assert id_of("mag0", param(own="CAL_MAG{n}_ID")) == "CAL_MAG0_ID"
    assert id_of("mag12", param(own="CAL_MAG{n}_ID")) == "CAL_MAG12_ID"
    assert id_of("mag", param(own="CAL_MAG{n}_ID")) == "CAL_MAG0_ID"
    assert id_of("mag3", param(own="CAL_MAG_ID")) == "CAL_MAG_ID"


def test_former_names_are_of_the_same_node_or_whole() -> None:
    keys = former_keys_of("tail", param("gain", "float", "1", "", "scale", "wing.gain"))
    assert keys == [key_of("tail", "scale"), key_of("wing", "gain")]


def test_a_definition_is_type_and_unit() -> None:
    definitions = [
        definition_of(param(kind=kind, unit=unit)) for kind in ("float", "int32") for unit in "ms"
    ]
    assert len(set(definitions)) == 4
    assert definition_of(param("other")) == definition_of(param("gain"))


@pytest.mark.parametrize("graph", GRAPHS, ids=lambda path: path.stem)
def test_ids_of_the_vehicles_fit_and_are_as_they_were(graph: Path) -> None:
    plan = make_plan(str(graph), None)
    ids = {
        f"{node.name}.{key}": id_of(node.name, value)
        for node in plan.graph.nodes.values()
        for key, value in node.interface.params.items()
    }
    assert len(ids) > 100
    assert max(map(len, ids.values())) <= 16
    places = {(plan.graph.nodes[name.split(".")[0]].machine, own) for name, own in ids.items()}
    assert len(places) == len(ids)  # on each machine: a standby has the ids of its node
    # People write these in files and scripts.
    assert ids["position_control.horizontal_speed_limit"] == "MPC_XY_VEL_MAX"
    assert ids["allocation.rotor11_moment"] == "CA_ROTOR11_KM"
    assert ids["rate_control.roll_p"] == "RATE_ROLLP_N7FF"
