"""Parameters by their ids, and values as people write them."""

from __future__ import annotations

import pytest

from stator import HOME
from stator.diagnostics import UserError
from stator.params.table import Row, bits_of, find, in_words, read_text, table_of, value_of_bits
from stator.pipeline import make_plan


@pytest.fixture(scope="module")
def table() -> list[Row]:
    return table_of(make_plan(str(HOME / "graph" / "quad_outdoor.yaml"), None).graph)


def test_the_order_is_that_of_the_vehicles_table(table: list[Row]) -> None:
    ids = [row.id for row in table]
    assert ids == sorted(ids)
    assert [row.index for row in table] == list(range(len(table)))


def test_a_parameter_is_found_by_either_name(table: list[Row]) -> None:
    assert find(table, "MPC_XY_VEL_MAX") is find(table, "position_control.horizontal_speed_limit")


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("MPC_XY_VEL_MXA", "did you mean 'MPC_XY_VEL_MAX'?"),
        ("mpc_xy_vel_max", "did you mean 'MPC_XY_VEL_MAX'?"),
        ("rate_control.rol_p", "did you mean 'rate_control.roll_p'?"),
    ],
)
def test_an_unknown_name_has_a_hint(table: list[Row], name: str, hint: str) -> None:
    with pytest.raises(UserError) as failed:
        find(table, name)
    assert str(failed.value) == f"error: unknown parameter '{name}'\nhint: {hint}"


def test_a_value_is_read_with_its_unit_or_in_the_parameters_own(table: list[Row]) -> None:
    speed = find(table, "MPC_XY_VEL_MAX")
    assert read_text(speed, "5") == read_text(speed, "5 m/s") == read_text(speed, "18 km/h") == 5.0
    tilt = find(table, "position_control.tilt_limit")
    assert read_text(tilt, "30 deg") == pytest.approx(0.5235988)
    assert read_text(find(table, "CA_ROTOR_COUNT"), "6") == 6
    airmode = find(table, "MC_AIRMODE")
    assert [read_text(airmode, text) for text in ("true", "false", "1", "0")] == [True, False] * 2


@pytest.mark.parametrize(
    ("name", "text", "error"),
    [
        ("MPC_XY_VEL_MAX", "25", "expected a value from 0.1 to 20 m/s"),
        ("MPC_XY_VEL_MAX", "5 kg", "expected a value in m/s"),
        ("MPC_XY_VEL_MAX", "fast", "expected a number"),
        ("MPC_XY_VEL_MAX", "nan", "expected a number"),
        ("MPC_XY_VEL_MAX", "", "expected a number"),
        ("CA_ROTOR_COUNT", "4.5", "expected a whole number"),
        ("CA_ROTOR_COUNT", "3", "expected a value from 4 to 12"),
        ("MC_AIRMODE", "2", "expected true or false"),
    ],
)
def test_a_value_that_it_cannot_have_is_refused(
    table: list[Row], name: str, text: str, error: str
) -> None:
    with pytest.raises(UserError, match=error):
        read_text(find(table, name), text)


def test_bits_are_those_of_the_vehicle(table: list[Row]) -> None:
    speed, count = find(table, "MPC_XY_VEL_MAX"), find(table, "CA_ROTOR_COUNT")
    airmode = find(table, "MC_AIRMODE")
    assert bits_of(speed, 1.0) == 0x3F800000
    assert bits_of(count, -1) == 0xFFFFFFFF
    assert bits_of(airmode, True) == 1
    for row, value in ((speed, 2.5), (count, -3), (airmode, True)):
        assert value_of_bits(row, bits_of(row, value)) == value


def test_a_float_is_shown_with_the_digits_that_it_has(table: list[Row]) -> None:
    row = find(table, "MPC_XY_VEL_MAX")
    assert in_words(row.stored(0.1)) == "0.1"
    assert in_words(row.stored(1 / 3)) == "0.33333334"
    assert in_words(row.stored(16777215.0)) == "16777215"
    assert in_words(10) == "10"
