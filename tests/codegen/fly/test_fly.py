"""`./stator fly` as a user runs it."""

import hashlib
import json
import signal
import subprocess
import time
from pathlib import Path
from typing import Any

import pytest
from pyulog import ULog

ROOT = Path(__file__).resolve().parents[3]


def fly(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    command = [str(ROOT / "stator"), "fly", *map(str, arguments)]
    return subprocess.run(command, check=False, capture_output=True, text=True)


def facts_of(finished: subprocess.CompletedProcess[str]) -> dict[str, Any]:
    assert finished.stdout, finished.stderr
    facts: dict[str, Any] = json.loads(finished.stdout)
    return facts


def assert_within_limits(seed: int, log: Path) -> None:
    finished = fly("--seed", str(seed), "-o", log, "--json")
    facts = facts_of(finished)
    assert facts["success"], f"seed {seed}: {facts['reason']}"
    assert finished.returncode == 0
    assert facts["hover_s"] >= 30.0
    assert facts["max_error_m"] <= 0.15
    assert facts["attitude_error_deg"] <= 0.5
    assert facts["touchdown_m_s"] < 0.7
    assert facts["lost_samples"] == 0
    assert Path(facts["log"]) == log
    assert facts["log_sha256"] == hashlib.sha256(log.read_bytes()).hexdigest()


@pytest.mark.parametrize("seed", [1, 2])
def test_takes_off_hovers_and_lands(seed: int, tmp_path: Path) -> None:
    assert_within_limits(seed, tmp_path / "flight.ulg")


@pytest.mark.long
@pytest.mark.parametrize("seed", range(1, 21))
def test_takes_off_hovers_and_lands_with_many_seeds(seed: int, tmp_path: Path) -> None:
    assert_within_limits(seed, tmp_path / "flight.ulg")


def test_same_seed_makes_the_same_log_and_another_another(tmp_path: Path) -> None:
    logs = []
    for name, seed in (("a", "7"), ("b", "7"), ("c", "8")):
        finished = fly("--seed", seed, "--duration", "5", "-o", tmp_path / name, "--json")
        logs.append(facts_of(finished)["log_sha256"])
    assert logs[0] == logs[1]
    assert logs[0] != logs[2]


def test_preempted_flight_is_good_and_repeats(tmp_path: Path) -> None:
    facts = [
        facts_of(fly("--times", "random", "-o", tmp_path / name, "--json")) for name in ("a", "b")
    ]
    assert facts[0]["success"], facts[0]["reason"]
    assert facts[0]["log_sha256"] == facts[1]["log_sha256"]


def test_log_starts_at_time_zero_and_holds_the_flight(tmp_path: Path) -> None:
    fly("--duration", "5", "-o", tmp_path / "flight.ulg")
    log = ULog(str(tmp_path / "flight.ulg"))
    assert log.start_timestamp == 0
    names = {dataset.name for dataset in log.data_list}
    assert names >= {"vehicle_attitude", "vehicle_local_position", "actuator_motors", "sensor_gyro"}


def test_flight_that_is_cut_short_fails_and_says_why(tmp_path: Path) -> None:
    finished = fly("--duration", "10", "-o", tmp_path / "flight.ulg")
    assert finished.returncode == 1
    assert "quad on sitl, seed 1: FAILED" in finished.stdout
    assert "reason    broken invariant: armed_at_the_end at 10.00 s" in finished.stdout
    why = "            --duration 10 s ended the flight early\n"
    assert f"{why}            not landed and disarmed: at 10.00 s in mode " in finished.stdout
    assert str(tmp_path / "flight.ulg") in finished.stdout


def test_a_graph_without_a_logger_ends_at_its_end(tmp_path: Path) -> None:
    graph = ROOT / "graph" / "examples" / "timer.yaml"
    finished = fly(graph, "--duration", "1", "-o", tmp_path / "timer.ulg", "--json")
    facts = facts_of(finished)
    assert (finished.returncode, facts["reason"]) == (0, "ran to its end")
    assert facts["recording"] is None
    # 2 ms after the start, and each 10 ms.
    assert facts["activations"] == 100


def test_report_names_every_limit(tmp_path: Path) -> None:
    finished = fly("-o", tmp_path / "flight.ulg")
    assert finished.returncode == 0
    lines = finished.stdout.splitlines()
    assert lines[0] == "quad on sitl, seed 1: success"
    labels = [line[2:11].strip() for line in lines[1:]]
    flight = ["take-off", "hover", "tilt", "touchdown"]
    assert labels == ["result", *flight, "run", "log", "storage", "next", ""]
    assert [limit for limit in ("0.15 m)", "0.5 deg)", "0.7 m/s)") if limit in finished.stdout]
    assert all(len(line) <= 100 + len(str(tmp_path)) for line in lines)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["--seed", "-1"],
            "argument --seed: expected a whole number from 0 to 18446744073709551615, found '-1'",
        ),
        (["--seed", "1.5"], "argument --seed: expected a whole number"),
        (["--duration", "0"], "argument --duration: expected seconds above 0"),
        (["--duration", "nan"], "argument --duration: expected seconds above 0"),
        (["--times", "one"], "argument --times: invalid choice: 'one'"),
        (["-o", "/no/such/folder/flight.ulg"], "cannot open '/no/such/folder/flight.ulg'"),
    ],
)
def test_wrong_arguments(arguments: list[str], message: str) -> None:
    finished = fly(*arguments)
    assert finished.returncode == 2
    assert finished.stdout == ""
    assert message in finished.stderr.replace("\n", " ")
    assert "Traceback" not in finished.stderr


def test_missing_graph(tmp_path: Path) -> None:
    finished = fly(tmp_path / "none.yaml", "--json")
    assert finished.returncode == 2
    assert finished.stdout == ""
    assert "none.yaml" in finished.stderr


def budgeted(folder: Path, nodes: list[str]) -> Path:
    """The quad, with the budgets of so many of its nodes: 60 us, 70 us, and so on."""
    graph = folder / "budgeted.yaml"
    graph.write_text("board: fmu_v2\ninclude: [{file: quad.yaml}]\n", encoding="utf-8")
    (folder / "budgets").mkdir()
    lines = "".join(f"{name}: {60 + 10 * i} us\n" for i, name in enumerate(nodes))
    (folder / "budgets" / "fmu_v2.yaml").write_text(lines, encoding="utf-8")
    return graph


NODES = [
    *("imu0", "rate_control", "allocation", "motors", "attitude", "attitude_control", "mocap0"),
    *("motor_loss", "position_estimate", "position_control", "sequence", "log_sink", "logger"),
]


def test_budgets_that_are_missing_are_named(tmp_path: Path) -> None:
    finished = fly(budgeted(tmp_path, NODES[:-2]), "--times", "budget")
    assert (finished.returncode, finished.stdout) == (2, "")
    assert (
        "error: missing budget of 'log_sink', 'logger': --times budget needs one" in finished.stderr
    )
    assert "to budgets/fmu_v2.yaml beside the graph" in finished.stderr


def test_budgets_let_time_pass(tmp_path: Path) -> None:
    graph, log = budgeted(tmp_path, NODES), tmp_path / "flight.ulg"
    facts = facts_of(fly(graph, "--times", "budget", "--json", "-o", log))
    assert facts["success"], facts["reason"]
    assert facts["lost_samples"] == 0
    # Each millisecond five nodes take 0.4 ms; whoever runs longer than the rest is interrupted.
    assert facts["preemptions"] > 10_000
    again = facts_of(fly(graph, "--times", "budget", "--json", "-o", log))
    assert again["log_sha256"] == facts["log_sha256"]


def test_an_interrupted_flight_has_a_report_a_log_and_its_status(tmp_path: Path) -> None:
    log = tmp_path / "flight.ulg"
    command = [str(ROOT / "stator"), "fly", "--speed", "0.5", "-o", str(log)]
    pipe = subprocess.PIPE
    process = subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True)
    # More than its definitions, and what is recorded meanwhile: samples.
    while process.poll() is None and not (log.exists() and log.stat().st_size > 100_000):
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    output, errors = process.communicate()
    assert process.returncode == 128 + signal.SIGINT, errors
    assert "quad on sitl, seed 1: FAILED" in output
    assert "SIGINT ended the flight early\n" in output
    assert f"log       {log} (" in output
    assert ULog(str(log)).get_dataset("sensor_gyro")
    facts = json.loads(log.with_suffix(".json").read_text())
    assert facts["success"] is False
    assert facts["duration_s"] < 20.0
