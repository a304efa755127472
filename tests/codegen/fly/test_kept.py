"""No flight overwrites the default log of an earlier one; its name says how it was flown."""

from __future__ import annotations

import argparse
import fcntl
import json
from pathlib import Path

import pytest

from stator import HOME
from stator.flight.arguments import add_flight_arguments
from stator.flight.kept import keeping, kept_facts, kept_rows, log_of
from stator.flight.params import add_param_argument, read_params
from stator.pipeline import make_plan


def arguments_of(*words: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    add_flight_arguments(parser, "sitl", "")
    add_param_argument(parser)
    return parser.parse_args([str(HOME / "graph" / "quad.yaml"), *words])


@pytest.mark.parametrize(
    ("words", "name"),
    [
        ("", "quad-seed1.ulg"),
        ("--seed 3", "quad-seed3.ulg"),
        ("--wind 5", "quad-seed1-wind5.ulg"),
        ("--wind 5.5 --wind-from 90", "quad-seed1-wind5.5-from90.ulg"),
        ("--gusts light --vary", "quad-seed1-gusts_light-vary.ulg"),
        ("--fail mocap0.stuck@3+2", "quad-seed1-mocap0.stuck@3+2.ulg"),
        ("--param rate_control.roll_p=0.1", "quad-seed1-rate_control.roll_p=0.1.ulg"),
        ("--mission graph/missions/hover.yaml", "quad-seed1-hover.ulg"),
    ],
)
def test_the_name_says_how_the_flight_differs(words: str, name: str) -> None:
    arguments = arguments_of(*words.replace("graph/missions", f"{HOME}/graph/missions").split())
    params = read_params(make_plan(str(arguments.graph), "sitl").graph, arguments.param)
    assert log_of(arguments, params).name == name
    assert log_of(arguments, params, ".run").name == name.replace(".ulg", ".run.ulg")


def test_a_long_name_is_a_hash() -> None:
    fails = [f"--fail=mocap0.stuck@{n}" for n in range(9)]
    names = {log_of(arguments_of(*fails[:n]), []).name for n in (8, 9)}
    assert len(names) == 2
    assert all(len(name) < 30 for name in names)


def fly(log: Path, content: bytes, truth: bytes = b"truth", *, named: bool = False) -> list[Path]:
    """What a flight leaves, and what was kept."""
    arguments = argparse.Namespace(output=log if named else None)
    with keeping(log, arguments) as kept:
        log.write_bytes(content)
        log.with_suffix(".truth").write_bytes(truth)
    facts = {"log": str(log), "truth": str(log.with_suffix(".truth")), "content": content.decode()}
    log.with_suffix(".json").write_text(json.dumps(facts))
    return kept


def test_earlier_logs_get_numbers_with_all_that_lies_beside_them(tmp_path: Path) -> None:
    log = tmp_path / "quad-seed1.ulg"
    (tmp_path / "quad-seed1.records").write_text("of no flight")
    (tmp_path / "quad-seed10.ulg").write_text("another flight")
    (tmp_path / "quad-seed1.1.ulg").write_text("before a restart")
    assert fly(log, b"first") == []
    log.with_suffix(".png").write_text("picture")
    assert fly(log, b"second") == [tmp_path / "quad-seed1-1.ulg"]
    assert fly(log, b"third") == [tmp_path / "quad-seed1-2.ulg"]
    assert {file.name for file in tmp_path.iterdir()} == {
        *("quad-seed10.ulg", "quad-seed1.records"),
        *("quad-seed1.ulg", "quad-seed1.truth", "quad-seed1.json"),
        *("quad-seed1-1.ulg", "quad-seed1-1.truth", "quad-seed1-1.json", "quad-seed1-1.png"),
        *("quad-seed1-1.1.ulg", "quad-seed1-2.ulg", "quad-seed1-2.truth", "quad-seed1-2.json"),
    }
    assert (tmp_path / "quad-seed1-1.ulg").read_bytes() == b"first"
    facts = json.loads((tmp_path / "quad-seed1-2.json").read_text())
    assert facts["content"] == "second"
    assert facts["log"] == str(tmp_path / "quad-seed1-2.ulg")
    assert facts["truth"] == str(tmp_path / "quad-seed1-2.truth")


def test_a_repeated_flight_is_kept_once(tmp_path: Path) -> None:
    log = tmp_path / "a.ulg"
    fly(log, b"same")
    log.with_suffix(".png").write_text("picture")
    assert fly(log, b"same") == []
    assert {file.name for file in tmp_path.iterdir()} == {"a.ulg", "a.truth", "a.json", "a.png"}
    assert fly(log, b"same", b"another truth") == [tmp_path / "a-1.ulg"]


@pytest.mark.parametrize("left", [None, b""])
def test_what_did_not_fly_takes_nothing_away(tmp_path: Path, left: bytes | None) -> None:
    log = tmp_path / "a.ulg"
    fly(log, b"first")
    with (
        pytest.raises(ValueError, match="no flight"),
        keeping(log, argparse.Namespace(output=None)),
    ):
        if left is not None:
            log.write_bytes(left)
        raise ValueError("no flight")
    assert log.read_bytes() == b"first"
    assert {file.name for file in tmp_path.iterdir()} == {"a.ulg", "a.truth", "a.json"}


def test_a_crash_before_the_first_block_keeps_the_earlier_log_apart(tmp_path: Path) -> None:
    log = tmp_path / "quad-seed1.ulg"
    fly(log, b"first")
    assert fly(log, b"") == [tmp_path / "quad-seed1-1.ulg"]
    assert log.read_bytes() == b""
    assert (tmp_path / "quad-seed1-1.ulg").read_bytes() == b"first"


def test_a_log_that_the_user_named_is_overwritten(tmp_path: Path) -> None:
    log = tmp_path / "a.ulg"
    fly(log, b"first", named=True)
    assert fly(log, b"second", named=True) == []
    assert {file.name for file in tmp_path.iterdir()} == {"a.ulg", "a.truth", "a.json"}


def test_the_log_of_a_flight_that_is_not_over_stays(tmp_path: Path) -> None:
    log = tmp_path / "a.ulg"
    log.write_bytes(b"being written")
    with log.open("ab") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        with keeping(log, argparse.Namespace(output=None)) as kept:
            assert log.read_bytes() == b"being written"
    assert kept == []


def test_the_report_says_where_the_earlier_log_is(tmp_path: Path) -> None:
    kept = tmp_path / "a-1.ulg"
    assert kept_rows(kept_facts([kept])) == [("kept", f"the earlier log is {kept}")]
    assert kept_rows(kept_facts([])) == []
