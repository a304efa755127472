"""A user lists and changes the parameters of a graph that runs on Linux, and starts it again."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path
from signal import SIGINT, SIGKILL
from typing import TYPE_CHECKING, Any

import pytest

from stator import __main__ as cli

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    Param = Callable[..., tuple[int, str, str]]

COMMAND = [sys.executable, "-I", "-X", "utf8", "-m", "stator", "run", "--json"]
GRAPH = Path(__file__).parent / "graph" / "dial.yaml"
START_S = 300.0  # until it is built and runs, on a busy machine


@contextmanager
def running(folder: Path) -> Iterator[subprocess.Popen[str]]:
    link, log = folder / "s", folder / "x.ulg"
    link.unlink(missing_ok=True)  # a killed run leaves it behind
    words = [str(GRAPH), "--link", str(link), "--duration", "3600", "-o", str(log)]
    words += ["--nonvolatile", str(folder / "x.records")]
    pipe = subprocess.PIPE
    process = subprocess.Popen([*COMMAND, *words], stdout=pipe, stderr=pipe, text=True)
    end = time.monotonic() + START_S
    while not link.exists() and process.poll() is None and time.monotonic() < end:
        time.sleep(0.05)
    try:
        assert link.exists(), process.communicate()[1]
        yield process
        process.send_signal(SIGINT)
        process.communicate()
    finally:
        process.kill()


@pytest.fixture
def param(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Param:
    place = ["--link", str(tmp_path / "s"), "--graph", str(GRAPH)]

    def call(action: str, *words: str) -> tuple[int, str, str]:
        capsys.readouterr()
        status = cli.main(["param", action, *words, *place])
        return status, *capsys.readouterr()

    return call


def values(param: Param) -> dict[str, Any]:
    """Once the memory has been read."""
    while True:
        facts = json.loads(param("list", "--json")[1])
        if facts["store"]["state"] == "loaded":
            return {row["id"]: row["value"] for row in facts["params"]} | {
                "stored": facts["store"]["stored"]
            }


def test_what_is_set_outlives_a_restart(tmp_path: Path, param: Param) -> None:
    defaults = {"DIAL_GAIN": 0.5, "DIAL_COUNT": 4, "DIAL_INVERTED": False, "DIAL_ADDRESS": 1}
    saved = tmp_path / "x.params"
    with running(tmp_path):
        assert values(param) == defaults | {"stored": 0}
        assert param("set", "dial.gain", "1.5") == (0, "DIAL_GAIN = 1.5 1/s (was 0.5)\nkept\n", "")
        assert param("set", "DIAL_INVERTED", "true")[0] == 0
        assert param("set", "DIAL_COUNT", "-3")[0] == 0
        status, _, error = param("set", "DIAL_ADDRESS", "2")
        assert (status, error.splitlines()[0]) == (
            1,
            "error: cannot set DIAL_ADDRESS: it cannot change while the graph runs",
        )
        assert param("set", "DIAL_COUNT", "8")[0] == 2
        assert param("save", str(saved))[0] == 0
    changed = defaults | {"DIAL_GAIN": 1.5, "DIAL_COUNT": -3, "DIAL_INVERTED": True}
    with running(tmp_path):
        assert values(param) == changed | {"stored": 3}
        assert "* DIAL_GAIN" in param("get", "DIAL_GAIN")[1]
        assert param("reset", "DIAL_GAIN")[0] == 0
        assert values(param)["stored"] == 2
        assert param("reset")[0] == 0
        assert values(param) == defaults | {"stored": 0}
        assert param("reset")[1] == "nothing to change\n"
        status, text, _ = param("load", str(saved))
        assert (status, text.splitlines()[-1]) == (0, "kept")
        assert values(param) == changed | {"stored": 3}
    status, _, error = param("list", "--log", str(tmp_path / "x.ulg"))
    assert (status, "not a ULog file" in error) == (2, True), "the graph has no logger"


def test_a_kill_right_after_the_answer_loses_nothing(tmp_path: Path, param: Param) -> None:
    with running(tmp_path) as process:
        values(param)
        assert param("set", "DIAL_GAIN", "1.25")[1].endswith("kept\n")
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text("utf-8")
        subprocess.run(["kill", f"-{SIGKILL}", children.split()[0]], check=True)
    with running(tmp_path):
        assert values(param)["DIAL_GAIN"] == 1.25
