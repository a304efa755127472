"""Flights of a campaign: the same table whatever the workers do, and what becomes of it."""

from __future__ import annotations

import json
import os
import shlex
import signal
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pyarrow.parquet as pq
import pytest
from distributed import LocalCluster

from stator import HOME
from stator import __main__ as cli
from stator.campaign.results import Results

if TYPE_CHECKING:
    from collections.abc import Iterator

FLIGHTS = 12
TEXT = f"""
doc: A vehicle that is hard to fly.
graph: {HOME / "graph" / "quad.yaml"}
flight:
  vehicle: varied
  wind: {{uniform: [0 m/s, 12 m/s]}}
  faults:
    - {{fault: motor_1.loss, chance: 30 %, at: {{uniform: [4 s, 9 s]}}}}
  params:
    rate_control.roll_p: {{uniform: [0.1 s/rad, 0.2 s/rad]}}
success:
  limits: {{touchdown_m_s: {{most: 1.5 m/s}}}}
find: {{input: wind, failures: 10 %}}
"""


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("campaign") / "hard.yaml"
    file.write_text(TEXT, encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """Of a cluster of another program, which is a thread here."""
    with LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0"
    ) as cluster:
        yield cluster.scheduler_address


def fly(file: Path, folder: Path, *more: str) -> int:
    words = ["campaign", str(file), "--flights", str(FLIGHTS), "-o", str(folder), "--json"]
    return cli.main([*words, "--pictures", "0", *more])


@pytest.fixture(scope="module")
def flown(file: Path, address: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("flown") / "results"
    assert fly(file, folder, "--cluster", address) == 0
    return folder


def table(folder: Path) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = pq.read_table(folder / "flights.parquet").to_pylist()
    return rows


def test_some_flights_fail_and_some_do_not(flown: Path) -> None:
    rows = table(flown)
    assert [row["flight"] for row in rows] == list(range(FLIGHTS))
    assert 2 <= sum(row["success"] for row in rows) <= FLIGHTS - 2
    assert all(row["success"] or row["reason"] for row in rows)
    broken = [row for row in rows if "motor_1.loss" in row["faults"]]
    assert broken
    assert not any(row["success"] for row in broken)


def test_killed_workers_and_interruptions_leave_no_trace(
    file: Path, flown: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two processes; the first result kills one of them, the sixth interrupts the campaign."""
    add, seen, folder = Results.add, [], tmp_path / "results"

    def disturb(results: Results, text: str) -> None:
        add(results, text)
        seen.append(json.loads(text)["flight"])
        if len(seen) == 1:
            os.kill(workers()[0], signal.SIGKILL)
        if len(seen) == 6:
            raise KeyboardInterrupt

    monkeypatch.setattr(Results, "add", disturb)
    assert fly(file, folder, "--workers", "2") == 130
    assert not (folder / "flights.parquet").exists()
    with (folder / "flights.jsonl").open("a", encoding="utf-8") as journal:
        journal.write('{"flight": 3, "succ')  # as if the power had failed
    assert fly(file, folder, "--workers", "1") == 0
    assert sorted(seen) == list(range(FLIGHTS))
    for name in ("flights.parquet", "campaign.json"):
        assert (folder / name).read_bytes() == (flown / name).read_bytes()
    assert sorted(path.name for path in folder.iterdir()) == [
        "campaign.json",
        "find.png",
        "flights.parquet",
        "report.html",
    ]


def workers() -> list[int]:
    """Processes of the local cluster."""
    children = Path(f"/proc/{os.getpid()}/task").glob("*/children")
    pids = [int(pid) for file in children for pid in file.read_text().split()]
    words = {pid: Path(f"/proc/{pid}/cmdline").read_bytes() for pid in pids}
    return sorted(pid for pid, line in words.items() if b"spawn_main" in line)


def test_a_flight_that_is_flown_alone_is_the_same(
    flown: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """By the command in the report, which has the words of the first failed flight."""
    failed = next(row for row in table(flown) if not row["success"])
    page = (flown / "report.html").read_text(encoding="utf-8")
    command = next(
        line.partition("<code>")[2].partition("</code>")[0]
        for line in page.splitlines()
        if f"--seed {failed['seed']} " in line
    )
    program, name, *words = shlex.split(command.replace("&#39;", "'"))
    assert (Path(program).name, name) == ("stator", "fly")
    graph = str(HOME / words[0])
    capsys.readouterr()
    cli.main(["fly", graph, *words[1:], "--no-record", "--json", "-o", str(tmp_path / "f.ulg")])
    facts = json.loads(capsys.readouterr().out)
    assert facts["log_sha256"] == failed["log_sha256"]
    assert facts["duration_s"] == failed["duration_s"]


def test_no_host_path_or_time_of_day(flown: Path) -> None:
    content = (flown / "flights.parquet").read_bytes()
    text = json.dumps(table(flown))
    for word in (str(HOME), os.uname().nodename, "/tmp"):
        assert word not in text
        assert word.encode() not in content


def test_the_report_stands_alone(flown: Path) -> None:
    page = (flown / "report.html").read_text(encoding="utf-8")
    assert "95 % interval after Wilson" in page
    assert "fault motor_1.loss" in page
    assert 'src="http' not in page
    assert page.count('src="data:image/png;base64,') >= 3


def test_more_flights_go_on_from_the_table(
    file: Path, flown: Path, address: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "more"
    folder.mkdir()
    for name in ("flights.parquet", "campaign.json"):
        (folder / name).write_bytes((flown / name).read_bytes())
    assert fly(file, folder, "--cluster", address, "--flights", str(FLIGHTS + 2)) == 0
    assert json.loads(capsys.readouterr().out)["flown_before"] == FLIGHTS
    assert table(folder)[:FLIGHTS] == table(flown)
    assert len(table(folder)) == FLIGHTS + 2


def test_results_of_another_campaign_are_not_continued(
    file: Path, flown: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = tmp_path / "other.yaml"
    other.write_text(TEXT.replace("12 m/s", "11 m/s"), encoding="utf-8")
    assert fly(other, flown) == 2
    assert "are of another campaign" in capsys.readouterr().err
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "thesis.txt").write_text("", encoding="utf-8")
    assert fly(file, tmp_path / "full") == 2
    assert "expected an empty folder" in capsys.readouterr().err


def test_a_cluster_that_is_not_there(
    file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert fly(file, tmp_path / "none", "--cluster", "nowhere") == 2
    assert "cannot connect to the cluster 'nowhere'" in capsys.readouterr().err


@pytest.mark.long
def test_a_thousand_flights(file: Path, tmp_path: Path) -> None:
    """By two workers and by one: the same bytes."""
    for workers in ("1", "2"):
        assert fly(file, tmp_path / workers, "--workers", workers, "--flights", "1000") == 0
    one, two = (tmp_path / workers / "flights.parquet" for workers in ("1", "2"))
    assert one.read_bytes() == two.read_bytes()
