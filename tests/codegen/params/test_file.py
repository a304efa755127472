"""Files of parameters: QGroundControl's format as it writes it, and MAVProxy's."""

from __future__ import annotations

from pathlib import Path

import pytest

from stator import HOME
from stator.diagnostics import UserError
from stator.params import file
from stator.params.table import Row, Value, find, table_of
from stator.pipeline import make_plan

# As QGroundControl 4 writes it, with values of its own precision.
HEAD = """# Onboard parameters for Vehicle 1
#
# Stack: PX4 Pro
# Vehicle: Multi-Rotor
# Version: 1.15.4
# Git Revision: 99c40407ff000000
#
# Vehicle-Id Component-Id Name Value Type
"""


@pytest.fixture(scope="module")
def table() -> list[Row]:
    return table_of(make_plan(str(HOME / "graph" / "quad_outdoor.yaml"), None).graph)


def defaults(table: list[Row]) -> dict[str, Value]:
    return {row.id: row.default for row in table}


def written(folder: Path, text: str) -> Path:
    path = folder / "x.params"
    path.write_text(text, encoding="utf-8")
    return path


def test_what_is_saved_loads_equal(tmp_path: Path, table: list[Row]) -> None:
    values = defaults(table)
    row = find(table, "MPC_XY_P")
    values |= {"MPC_XY_P": row.stored(1 / 3), "MC_AIRMODE": True, "CA_ROTOR_COUNT": 6}
    file.write(tmp_path / "x.params", "quad_outdoor", table, values)
    loaded = file.read(tmp_path / "x.params", table)
    assert loaded.values == values
    assert (loaded.unknown, loaded.other_type) == ([], [])
    lines = (tmp_path / "x.params").read_text(encoding="utf-8").splitlines()
    assert "1\t1\tCA_ROTOR_COUNT\t6\t6" in lines
    assert "1\t1\tMC_AIRMODE\t1\t6" in lines
    assert "1\t1\tMPC_XY_P\t0.33333334\t9" in lines
    assert lines[0].startswith("#")


def test_unknown_names_and_other_types_are_skipped(tmp_path: Path, table: list[Row]) -> None:
    text = HEAD + (
        "1\t1\tMPC_XY_VEL_MAX\t12.000000000000000000\t9\n"
        "1\t1\tSYS_AUTOSTART\t4001\t6\n"
        "1\t1\tCA_ROTOR_COUNT\t6.0\t9\n"
    )
    loaded = file.read(written(tmp_path, text), table)
    assert loaded.values == {"MPC_XY_VEL_MAX": 12.0}
    assert loaded.unknown == ["SYS_AUTOSTART"]
    assert loaded.other_type == ["CA_ROTOR_COUNT"]


def test_mavproxys_files_are_read(tmp_path: Path, table: list[Row]) -> None:
    text = "# a comment\nMPC_XY_VEL_MAX   12.000000\nCA_ROTOR_COUNT,6.000000\nMC_AIRMODE 1\n"
    loaded = file.read(written(tmp_path, text), table)
    assert loaded.values == {"MPC_XY_VEL_MAX": 12.0, "CA_ROTOR_COUNT": 6, "MC_AIRMODE": True}


def test_a_range_ends_where_its_float_does(tmp_path: Path, table: list[Row]) -> None:
    """0.9 as a float is 0.89999998, and as QGroundControl writes that, 0.899999976158142."""
    loaded = file.read(written(tmp_path, "1\t1\tMPC_THR_HOVER\t0.899999976158142090\t9\n"), table)
    row = find(table, "MPC_THR_HOVER")
    assert loaded.values == {"MPC_THR_HOVER": row.stored(0.9)}


@pytest.mark.parametrize(
    ("line", "error"),
    [
        ("7\t1\tMPC_XY_VEL_MAX\t12\t9", "expected parameters of vehicle 1, found vehicle '7'"),
        ("1\t1\tMPC_XY_VEL_MAX\t50\t9", "expected a value from 0.1 to 20 m/s"),
        ("1\t1\tMPC_XY_VEL_MAX\tnan\t9", "expected a number, found 'nan'"),
        ("1\t1\tMPC_XY_VEL_MAX\tinf\t9", "expected a number, found 'inf'"),
        ("1\t1\tCA_ROTOR_COUNT\t4.5\t6", "expected a whole number"),
        ("1\t1\tMPC_XY_VEL_MAX", "expected a parameter, found"),
    ],
)
def test_one_error_stops_all(tmp_path: Path, table: list[Row], line: str, error: str) -> None:
    path = written(tmp_path, f"{HEAD}1\t1\tMPC_XY_P\t1\t9\n{line}\n")
    with pytest.raises(UserError) as failed:
        file.read(path, table)
    text = str(failed.value)
    assert text.startswith("x.params:10: error: ")
    assert error in text
    assert text.endswith("nothing was changed")


def test_a_file_that_is_missing_is_told(tmp_path: Path, table: list[Row]) -> None:
    with pytest.raises(UserError, match="error: cannot read"):
        file.read(tmp_path / "none.params", table)
    with pytest.raises(UserError, match="error: cannot write"):
        file.write(tmp_path / "none" / "x.params", "quad", table, defaults(table))
