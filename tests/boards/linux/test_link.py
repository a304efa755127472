"""A user looks at a graph that runs on Linux: top, perf and listener, by their command lines."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path
from signal import SIGINT
from typing import TYPE_CHECKING, Any

import pytest
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from stator import HOME
from stator import __main__ as cli
from stator.build.cmake import PLAIN, build
from stator.live import place as link_place
from stator.live.link import Link, NoLink
from stator.live.place import graph_of
from stator.pipeline import make_plan

if TYPE_CHECKING:
    from collections.abc import Iterator

COMMAND = [sys.executable, "-I", "-X", "utf8", "-m", "stator", "run", "--json"]
VIEW = Subprotocol("foxglove.websocket.v1")
START_S = 300.0  # until it is built and runs, on a busy machine


WAITS = Path(__file__).parent / "graph" / "waits.yaml"
NO_LOGGER = Path(__file__).parent / "graph" / "no_logger.yaml"


def start(graph: Path, link: Path, duration_s: str) -> subprocess.Popen[str]:
    words = [
        str(graph),
        "--link",
        str(link),
        "--duration",
        duration_s,
        "-o",
        str(link.with_suffix(".ulg")),
    ]
    pipe = subprocess.PIPE
    process = subprocess.Popen([*COMMAND, *words], stdout=pipe, stderr=pipe, text=True)
    wait_for(link, process)
    return process


def wait_for(link: Path, process: subprocess.Popen[Any]) -> None:
    end = time.monotonic() + START_S
    while not link.exists() and process.poll() is None and time.monotonic() < end:
        time.sleep(0.05)
    if not link.exists():
        process.kill()
        pytest.fail(f"nothing runs: {process.communicate()[1]}")


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Path, int]]:
    """The link of a run that lasts until the tests are over, and the process of its threads."""
    link = tmp_path_factory.mktemp("link") / "s"
    process = start(WAITS, link, "3600")
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text(encoding="utf-8")
    with Link(link) as other:  # somebody who looks all the time, and at last does not read
        other.info()
        yield link, int(children.split()[0])
        process.send_signal(SIGINT)
        facts = json.loads(process.communicate()[0])
    assert process.returncode == 128 + SIGINT
    assert facts["reason"].startswith("SIGINT after")
    assert not link.exists()
    assert graph_of(link) is None


@pytest.fixture
def place(running: tuple[Path, int]) -> list[str]:
    """No graph: the run has left its path with the link."""
    return ["--link", str(running[0])]


def ask(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    capsys.readouterr()
    assert cli.main([*words]) == 0, capsys.readouterr().err
    return capsys.readouterr().out


def cpu_s(process: int) -> float:
    """CPU time that all threads have used."""
    tasks = Path(f"/proc/{process}/task").glob("*/schedstat")
    return sum(int(file.read_text(encoding="utf-8").split()[0]) for file in tasks) * 1e-9


def test_top_shows_what_each_task_takes(
    running: tuple[Path, int], place: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    _, process = running
    interval_s = 2.5  # more than one look, as sums of nanoseconds wrap
    before_s = cpu_s(process)
    words = ["top", *place, "--once", "--json", "--interval", str(interval_s)]
    facts = json.loads(ask(capsys, *words))
    used_s = cpu_s(process) - before_s
    assert (facts["graph"], facts["board"]) == ("waits", "linux")
    assert facts["measured_in"] == "cpu_time"
    assert facts["uptime_s"] >= interval_s
    tasks = {row["task"]: row for row in facts["tasks"]}
    assert tasks["rate_control"]["level"] == 13
    for row in tasks.values():
        assert row["activations"] > 0, row
        assert 0 < row["last_us"] <= row["max_us"], row
    # What the tasks take is part of what the process takes; the looks lie a little further apart
    # than the interval.
    assert 0 < sum(row["load_pct"] for row in tasks.values()) * 0.01 * interval_s <= used_s


def test_top_fits_a_terminal(place: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    table = ask(capsys, "top", *place, "--once", "--interval", "0.3")
    assert all(len(line) <= 80 for line in table.splitlines())
    assert " position_estimate " in table
    assert "CPU time" in table


def test_perf_sets_bounds_beside_figures(
    place: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    facts = json.loads(ask(capsys, "perf", *place, "--json"))
    (chain,) = facts["chains"]
    assert (chain["chain"], chain["deadline_us"]) == ("gyro_to_motor", 500)
    responses = {row["task"]: row["response_max_us"] for row in facts["tasks"]}
    assert chain["latency_max_us"] is None  # the status wakes the allocation, too
    assert responses["imu0"] is None  # nothing in the graph is about its end
    # Which of the two is longer is open: a task may end after those that it woke.
    assert responses["rate_control"] > 0
    assert responses["motors"] > 0
    assert "gyro_to_motor" in ask(capsys, "perf", *place)


def test_listener_decodes_samples(place: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    words = ["listener", "vehicle_attitude", *place, "--count", "3"]
    samples = [json.loads(line) for line in ask(capsys, *words, "--json").splitlines()]
    assert [sample["number"] for sample in samples] == sorted({s["number"] for s in samples})
    assert len(samples) == 3
    for sample in samples:
        q = sample["fields"]["q"]
        assert sum(part * part for part in q) == pytest.approx(1.0, abs=1e-5)
    text = ask(capsys, "listener", "vehicle_status", *place, "--count", "1")
    assert "arming_state" in text


def test_another_graph_is_refused(
    running: tuple[Path, int], capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["top", "--once", "--link", str(running[0])]
    assert cli.main([*words, "--graph", str(HOME / "graph" / "quad.yaml")]) == 2
    assert "another version" in capsys.readouterr().err
    assert cli.main(words) == 0  # the run has left the path of its graph


def test_nobody_there(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(link_place, "DEFAULT", tmp_path / "link")  # others may run now
    for command in (["top"], ["perf"], ["listener", "vehicle_attitude"]):
        assert cli.main([*command, "--link", str(tmp_path / "none")]) == 2
        error = capsys.readouterr().err
        assert "error: cannot connect to" in error
        assert "./stator run" in error


def test_the_link_of_another_run_is_left_to_it(
    running: tuple[Path, int],
    place: list[str],
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    words = ["run", "--link", str(running[0])]
    assert cli.main([*words, "-o", str(tmp_path / "second.ulg")]) == 2
    assert "error: another run uses" in capsys.readouterr().err
    assert not (tmp_path / "second.ulg").exists()
    ask(capsys, "perf", *place)


def test_a_place_that_is_none_is_refused(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "notes"
    file.write_text("kept", encoding="utf-8")
    assert cli.main(["run", "--link", str(file)]) == 2
    assert "expected a socket, found another file" in capsys.readouterr().err
    assert cli.main(["run", "--link", str(tmp_path / ("long" * 30))]) == 2
    assert "expected a path of at most" in capsys.readouterr().err
    assert file.read_text(encoding="utf-8") == "kept"


def test_a_run_ends_in_order_while_somebody_looks(tmp_path: Path) -> None:
    link = tmp_path / "s"
    process = start(NO_LOGGER, link, "1.5")
    with Link(link) as looking, pytest.raises(NoLink, match="lost the connection"):
        while True:
            looking.tasks(looking.info().tasks)
    output, errors = process.communicate()
    assert errors == ""
    facts = json.loads(output)
    assert facts["reason"].endswith("ran to its end")  # a busy machine may miss life signs
    assert facts["duration_s"] >= 1.5
    assert facts["link"] == str(link)
    assert not link.exists()


def test_a_build_without_counters_says_so(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    program = build(NO_LOGGER, "linux", PLAIN, executor="pthread")
    link = tmp_path / "s"
    command = [program, "--link", link, "--duration", "3600"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as process:
        wait_for(link, process)
        words = ["top", "--link", str(link), "--graph", str(NO_LOGGER), "--interval", "0.1"]
        facts = json.loads(ask(capsys, *words, "--json"))
        text = ask(capsys, *words, "--once")
        process.terminate()
    (row,) = facts["tasks"]
    assert facts["measured_in"] == "nothing"
    assert row["activations"] > 0
    assert {row[key] for key in ("load_pct", "last_us", "mean_us", "max_us")} == {None}
    assert "no times" in text


def test_view_shows_it(running: tuple[Path, int]) -> None:
    """What the page is told of the tasks that run and the topics that they publish."""
    command = [sys.executable, "-I", "-X", "utf8", "-m", "stator", "view", "--port", "0"]
    words = ["--link", str(running[0]), "--graph", str(WAITS)]
    with subprocess.Popen([*command, *words], stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            place = process.stdout.readline().split("/")[2]
            with connect(f"ws://{place}/", subprotocols=[VIEW]) as viewer:
                json.loads(viewer.recv(timeout=START_S))
                channels = json.loads(viewer.recv(timeout=START_S))["channels"]
                state = next(c["id"] for c in channels if c["topic"] == "/stator/state")
                ask = {"op": "subscribe", "subscriptions": [{"id": 7, "channelId": state}]}
                viewer.send(json.dumps(ask))
                told = json.loads(viewer.recv(timeout=START_S)[13:])
        finally:
            process.send_signal(SIGINT)
            assert process.wait(START_S) == 0
    plan = make_plan(str(WAITS), "linux")
    assert [task["task"] for task in told["tasks"]] == [task.node.name for task in plan.tasks]
    assert any(task["activations"] > 0 for task in told["tasks"])
