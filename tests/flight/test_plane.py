"""An aeroplane flies a mission; in wind and with failures by --long."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import pytest

from stator import HOME
from stator import __main__ as cli

if TYPE_CHECKING:
    from pathlib import Path

PLANE = HOME / "graph" / "plane.yaml"
SQUARE = HOME / "graph" / "missions" / "plane_square.yaml"
WIND = ("--wind", "8", "--gusts", "moderate")


def fly(log: Path, capsys: pytest.CaptureFixture[str], *more: str) -> dict[str, Any]:
    capsys.readouterr()
    cli.main(["fly", str(PLANE), "--mission", str(SQUARE), "-o", str(log), "--json", *more])
    facts: dict[str, Any] = json.loads(capsys.readouterr().out)
    return facts


def test_flies_a_square_from_the_runway_to_the_runway(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    facts = fly(tmp_path / "flight.ulg", capsys)
    assert facts["reason"] == "landed and disarmed, within all limits"
    assert facts["items_reached"] == facts["items_total"] == 5
    assert [mode["mode"] for mode in facts["modes"] if mode["armed"]] == [
        "mission",
        "return",
        "landing",
    ]
    assert facts["landing_error_m"] < 40.0


@pytest.mark.long
def test_flies_it_in_wind_and_gusts_twenty_times(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    missed = []
    for seed in range(1, 21):
        facts = fly(tmp_path / "flight.ulg", capsys, *WIND, "--seed", str(seed))
        if not facts["success"]:
            missed.append((seed, facts["reason"]))
    assert missed == []


@pytest.mark.long
@pytest.mark.parametrize("failure", ["airspeed0.blocked", "airspeed0.stuck", "airspeed0.drop_out"])
def test_lands_without_an_airspeed(
    failure: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    facts = fly(tmp_path / "flight.ulg", capsys, "--fail", f"{failure}@40")
    assert facts["items_reached"] == 5
    assert facts["touchdown_m_s"] < 2.5


@pytest.mark.long
def test_glides_down_when_its_motor_is_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    facts = fly(tmp_path / "flight.ulg", capsys, "--fail", "motor_1.loss@50")
    assert facts["modes"][-1] == {**facts["modes"][-1], "armed": False}
    assert facts["touchdown_m_s"] < 3.0
