"""`./stator new`: what it writes builds and flies as it is, and nothing is ever replaced."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from pyulog import ULog

from stator import __main__ as cli
from stator.diagnostics import entry


def test_a_new_app_in_a_new_graph_flies_as_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cli.main(["new", "app", "lean_alarm"]) == 0
    assert f"next: {entry()} new graph lean_alarm_quad --app lean_alarm" in capsys.readouterr().out
    assert cli.main(["new", "graph", "lean_alarm_quad", "--app", "lean_alarm"]) == 0
    assert f"next: {entry()} fly lean_alarm_quad.yaml" in capsys.readouterr().out
    assert cli.main(["fly", "lean_alarm_quad.yaml", "--json", "-o", "log.ulg"]) == 0
    facts = json.loads(capsys.readouterr().out)
    parameters = ULog(facts["log"]).initial_parameters
    assert parameters["lean_alarm.limit"] == 0.5


def test_a_new_graph_is_good(tmp_path: Path) -> None:
    assert cli.main(["new", "graph", "racer", "--in", str(tmp_path)]) == 0
    assert cli.main(["check", str(tmp_path / "racer.yaml")]) == 0


def test_a_new_vehicle_is_good_and_a_graph_flies_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cli.main(["new", "vehicle", "heavy", "--like", "iris"]) == 0
    assert f"next: {entry()} check vehicles/heavy.yaml" in capsys.readouterr().out
    file = tmp_path / "vehicles" / "heavy.yaml"
    file.write_text(file.read_text().replace("mass: 1.535 kg", "mass: 1.9 kg"))
    assert cli.main(["check", "vehicles/heavy.yaml"]) == 0
    assert "1.9 kg, 4 rotors, thrust 1.52 times the weight" in capsys.readouterr().out
    assert cli.main(["new", "graph", "heavy_quad", "--vehicle", "heavy"]) == 0
    capsys.readouterr()
    assert cli.main(["explain", "heavy_quad.yaml", "position_control"]) == 0
    assert "param hover_thrust 0.659 (default)" in " ".join(capsys.readouterr().out.split())
    assert cli.main(["explain", "heavy_quad.yaml", "heavy"]) == 0
    assert "1.52 times the weight" in capsys.readouterr().out


def test_nothing_is_replaced(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    header = tmp_path / "apps" / "lean_alarm" / "lean_alarm.hpp"
    header.parent.mkdir(parents=True)
    header.write_text("mine")
    assert cli.main(["new", "app", "lean_alarm", "--in", str(tmp_path)]) == 2
    assert "exists already" in capsys.readouterr().err
    assert header.read_text() == "mine"
    assert [path.name for path in header.parent.iterdir()] == ["lean_alarm.hpp"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["app", "Lean"], "error: expected a name, found 'Lean'"),
        (["app", "../up"], "error: expected a name, found '../up'"),
        (["app", "while"], "error: 'while' cannot be a name: it is a C++ keyword"),
        (["app", "topic"], "error: 'topic' cannot be a name: the runtime uses this name"),
        (["app", "rate_control"], "error: duplicate app 'rate_control'"),
        (["vehicle", "heavy", "--like", "irish"], "error: unknown vehicle 'irish'\nhint: did you"),
        (["graph", "racer", "--vehicle", "absent"], "error: unknown vehicle 'absent'"),
        (["graph", "racer", "--app", "absent"], "error: unknown app 'absent' in "),
    ],
)
def test_what_cannot_be_made(
    arguments: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["new", *arguments, "--in", str(tmp_path)]) == 2
    assert capsys.readouterr().err.startswith(message)
    assert list(tmp_path.iterdir()) == []
