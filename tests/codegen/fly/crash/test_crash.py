"""A node that prints, crashes or does not end: what the person at the terminal reads."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from stator import HOME
from stator import __main__ as cli

GRAPH = Path(__file__).parent / "graph"


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return Path(shutil.copytree(GRAPH, tmp_path_factory.mktemp("crash") / "project"))


def fly(project: Path, how: int, *more: str) -> int:
    graph = str(project / "breaks.yaml")
    return cli.main(["fly", graph, "--duration", "2", "--param", f"breaks.how={how}", *more])


def facts_of(project: Path, how: int, capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    status = fly(project, how, "--json")
    facts: dict[str, Any] = json.loads(capsys.readouterr().out)
    assert (status == 0) == facts["success"]
    return facts


def line_of(comment: str) -> int:
    code = (GRAPH / "apps" / "breaks" / "breaks.cpp").read_text(encoding="utf-8").splitlines()
    return next(n for n, line in enumerate(code, 1) if line.endswith(f"// {comment}"))


@pytest.mark.parametrize(
    ("how", "signal", "comment"),
    [
        (2, "SIGSEGV", "segv"),
        (3, "SIGFPE", "fpe"),
        (4, "SIGABRT", "abort"),
        (5, "ENDLESS", "endless"),
    ],
)
def test_a_crash_names_node_time_and_line(
    how: int, signal: str, comment: str, project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    facts = facts_of(project, how, capsys)
    file = str(project / "apps" / "breaks" / "breaks.cpp")
    assert facts["crash"] == {
        "signal": signal,
        "node": "breaks",
        "input": None,
        "at_s": pytest.approx(1.0),
        "file": file,
        "line": line_of(comment),
    }
    assert f"at 1.000000 s, in {file}:{line_of(comment)}" in facts["reason"]


def test_an_absent_input_is_named(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    crash = facts_of(project, 1, capsys)["crash"]
    assert (crash["node"], crash["input"], crash["line"]) == ("breaks", "status", line_of("absent"))
    assert fly(project, 1) == 1
    shown, errors = capsys.readouterr()
    assert errors == ""  # it is said once
    assert "node 'breaks' read the absent input 'status' at 1.000000 s" in shown
    graph = project / "breaks.yaml"
    command = (
        f"./stator debug {graph} --duration 2 --param breaks.how=1 --node breaks --at 1.000000"
    )
    assert f"stop there in a debugger: {command}\n" in shown


def test_an_endless_recursion_is_named(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    crash = facts_of(project, 6, capsys)["crash"]
    assert (crash["signal"], crash["node"]) == ("SIGSEGV", "breaks")
    assert crash["file"] == str(project / "apps" / "breaks" / "breaks.cpp")


def test_a_thread_that_dies_is_named(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It has a stack of its own for the report, as the main one has."""
    graph = str(project / "breaks.yaml")
    options = ["--param", "breaks.how=6", "--duration", "60", "-o", str(project / "thread.ulg")]
    assert cli.main(["run", graph, "--json", "--link", str(project / "link"), *options]) == 1
    crash = json.loads(capsys.readouterr().out)["crash"]
    assert (crash["signal"], crash["node"]) == ("SIGSEGV", "breaks")
    assert crash["at_s"] >= 1.0


def test_what_a_node_prints_has_time_and_name(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert fly(project, 7, "--json") == 0
    out, err = capfd.readouterr()
    assert json.loads(out)["success"]
    assert [line for line in err.splitlines() if line.startswith("[")] == [
        "[   1.000000 s] breaks: count 1001",
        "[   1.001000 s] breaks: count 1002",
    ]


@pytest.mark.long  # builds the world and the quad once more
def test_sanitizers_find_what_flies_without_them(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert fly(project, 8, "--json", "--sanitize") == 1
    out, err = capfd.readouterr()
    crash = json.loads(out)["crash"]
    assert (crash["node"], crash["line"]) == ("breaks", line_of("bounds"))
    assert "index 8 out of bounds" in err
    assert fly(project, 8, "--sanitize") == 1
    assert "let sanitizers" not in capfd.readouterr().out
    assert fly(project, 2) == 1
    assert "let sanitizers" in capfd.readouterr().out


@pytest.mark.skipif(shutil.which("gdb") is None, reason="gdb is not installed")
def test_the_debugger_stops_at_the_crash(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    facts_of(project, 3, capsys)
    command = [sys.executable, "-I", "-m", "stator", "debug", str(project / "breaks.yaml")]
    command += ["--param", "breaks.how=3"]
    finished = subprocess.run(
        command,
        input="next\nnext\nnext\nnext\nprint how\nprint ports.now\nbt\nkill\nquit\n",
        capture_output=True,
        text=True,
        check=False,
    )
    words = " ".join(finished.stdout.split())
    assert "Breakpoint 1, stator::apps::breaks::Breaks::step (" in words, finished.stderr
    assert "$1 = 3 " in words
    assert "$2 = 1000000 " in words


MATRICES = """
#include <Eigen/Dense>
int main() {
    const Eigen::Vector3f v(1.5F, -2.0F, 3.0F);
    const Eigen::Matrix<float, 1, 2> row(4.0F, 5.0F);
    Eigen::Matrix2d m;
    m << 1, 2, 3, 4;
    Eigen::Matrix<int, 2, 2, Eigen::RowMajor> r;
    r << 5, 6, 7, 8;
    const Eigen::Quaternionf q(1.0F, 0.5F, 0.25F, 0.125F);
    return v.x() > 5.0F || row.x() > 5.0F || m(0, 0) > 5.0 || r(0, 0) > 6 || q.w() > 5.0F;
}
"""


@pytest.mark.skipif(shutil.which("gdb") is None, reason="gdb is not installed")
def test_the_debugger_shows_matrices_by_their_numbers(tmp_path: Path) -> None:
    source, program = tmp_path / "m.cpp", tmp_path / "m"
    source.write_text(MATRICES)
    compiled = ["g++", "-std=c++20", "-g", "-O0", "-isystem", "/usr/include/eigen3"]
    subprocess.run([*compiled, source, "-o", program], check=True)
    line = next(n for n, text in enumerate(MATRICES.splitlines(), 1) if "return" in text)
    commands = [f"source {HOME}/runtime/host/gdb_printers.py", f"break m.cpp:{line}", "run"]
    commands += [f"print {name}" for name in ("v", "row", "m", "r", "q")]
    words = [word for text in commands for word in ("-ex", text)]
    finished = subprocess.run(
        ["gdb", "-q", "-batch", *words, program], capture_output=True, text=True, check=True
    )
    assert re.findall(r"^\$\d = (.*)$", finished.stdout, re.MULTILINE) == [
        "[1.5, -2, 3]",
        "[4, 5]",
        "[1, 2; 3, 4]",
        "[5, 6; 7, 8]",
        "w 1, x 0.5, y 0.25, z 0.125",
    ]


def test_the_debugger_needs_a_node(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    facts_of(project, 3, capsys)
    graph = str(project / "breaks.yaml")
    assert cli.main(["debug", graph, "--seed", "77"]) == 2
    assert capsys.readouterr().err == (
        "error: missing option --node: no crash of such a flight is known\n"
        "hint: 'breaks' crashed in another flight: "
        f"./stator debug {graph} --duration 2 --param breaks.how=3\n"
    )
    assert cli.main(["debug", graph, "--node", "brakes"]) == 2
    assert "did you mean 'breaks'?" in capsys.readouterr().err
    assert cli.main(["debug", graph, "--node", "breaks", "--at", "0.5", "--print"]) == 0
    shown = capsys.readouterr().out
    assert "graph_program --log" in shown
    assert (
        "break at: stator::apps::breaks::Breaks::step, if stator::executor.now_us >= 500000"
        in shown
    )
