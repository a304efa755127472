"""The file of a run in which records outlive it, as a user sees it: whole, damaged, and in use."""

from __future__ import annotations

import fcntl
import json
from pathlib import Path
from typing import Any

import pytest

from stator import HOME
from stator import __main__ as cli
from stator.flight.nonvolatile import nonvolatile_rows

# Keeps one record at each start.
GRAPH = HOME / "tests" / "drivers" / "system" / "graph" / "keep.yaml"
HEAD_BYTES, HALF_BYTES = 4096, 8192  # drivers/nonvolatile


@pytest.fixture
def records(tmp_path: Path) -> Path:
    return tmp_path / "kept.records"


def run(records: Path) -> int:
    log = records.with_suffix(".ulg")
    options = ["--duration", "1.5", "--json", "-o", str(log), "--nonvolatile", str(records)]
    options += ["--link", str(records.with_suffix(".link"))]
    return cli.main(["run", str(GRAPH), *options])


def told(records: Path, capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    capsys.readouterr()
    assert run(records) in (0, 1)  # 1: the machine was too busy for the life signs of a task
    facts: dict[str, Any] = json.loads(capsys.readouterr().out)
    assert facts["nonvolatile"]["file"] == str(records)
    return facts


def flip(records: Path, *places: int) -> None:
    content = bytearray(records.read_bytes())
    for place in places:
        content[place] ^= 4
    records.write_bytes(content)


def counts(facts: dict[str, Any]) -> tuple[int, int, int]:
    memory = facts["nonvolatile"]
    return memory["records"], memory["mended"], memory["damaged"]


def test_damage_is_mended_or_told(records: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert counts(told(records, capsys)) == (1, 0, 0)
    whole = records.read_bytes()
    assert len(whole) == HEAD_BYTES + 2 * HALF_BYTES
    flip(records, HEAD_BYTES + 20)
    facts = told(records, capsys)
    assert counts(facts) == (1, 1, 0)
    assert "repaired (one of two copies was damaged): 1" in nonvolatile_rows(facts)[1][1]
    flip(records, 3, HEAD_BYTES + 20, HEAD_BYTES + HALF_BYTES + 20)  # and the head
    facts = told(records, capsys)
    assert counts(facts) == (1, 0, 1), "of its place, it made use again"
    assert nonvolatile_rows(facts)[1][1].startswith("damaged and lost: 1")


def test_a_file_that_lost_its_end_is_whole_again(
    records: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    told(records, capsys)
    records.write_bytes(records.read_bytes()[: HEAD_BYTES + 100])
    assert counts(told(records, capsys)) == (1, 1, 0)


def refusal(records: Path, capsys: pytest.CaptureFixture[str]) -> str:
    capsys.readouterr()
    assert run(records) == 2
    out, err = capsys.readouterr()
    assert out == ""
    return err


def test_what_is_no_such_file_is_left_alone(
    records: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    records.write_text("dear diary")
    assert "expected a file of records" in refusal(records, capsys)
    assert records.read_text() == "dear diary"
    assert "Is a directory" in refusal(records.parent, capsys)


def test_another_run_has_it(records: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with records.open("wb") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        assert "another run uses it" in refusal(records, capsys)
