"""The exit status says the same of every command: docs/json.md."""

import errno
import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from stator import HOME
from stator import __main__ as cli

WRONG = "board: fmu_v2\nnodes:\n  imu0: {devcie: imu0}\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "wrong.yaml").write_text(WRONG)
    (tmp_path / "wrong.ulg").write_text("no log")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("graph", ["wrong.yaml", "missing.yaml"])
def test_errors_are_the_answer_of_check(folder: Path, graph: str) -> None:
    assert cli.main(["check", graph]) == 1
    assert cli.main(["check", graph, "--json"]) == 1


@pytest.mark.parametrize(
    "command",
    [
        "gen wrong.yaml -o out",
        "graph wrong.yaml -o out.svg",
        "graph {home}/graph/quad.yaml -o out.gif",
        "explain wrong.yaml imu0",
        "explain {home}/graph/quad.yaml imu1",
        "new app 9x",
        "new graph wrong",
        "fly wrong.yaml",
        "fly --mission wrong.yaml",
        "fly --mission missing.yaml",
        "run wrong.yaml",
        "build wrong.yaml",
        "build {home}/graph/quad.yaml --board linux",
        "flash wrong.yaml",
        "emulate wrong.yaml",
        "top --link missing",
        "plot missing.ulg",
        "plot wrong.ulg",
        "replay missing.ulg",
        "replay wrong.ulg",
        "score attitude missing",
        "score navigation missing",
        "bench nothing",
        "",
    ],
)
def test_what_a_command_cannot_do(
    folder: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    before = sorted(folder.iterdir())
    words = [word.format(home=HOME) for word in command.split()]
    assert cli.main(words) == 2
    captured = capsys.readouterr()
    assert not captured.out
    assert "error: " in captured.err or "usage: " in captured.err
    assert "Traceback" not in captured.err
    assert sorted(folder.iterdir()) == before


def test_what_the_machine_refuses(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refused(*_: object) -> None:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), "/place")

    monkeypatch.setattr("stator.plan.hash.graph_hash", refused)
    assert cli.main(["check", str(HOME / "graph" / "quad.yaml"), "--json"]) == 2
    assert capsys.readouterr().err == "error: cannot use '/place': Permission denied\n"


def test_what_cannot_be_written_is_not_done() -> None:
    """Not Python's own status, 120, with what it calls an ignored exception."""
    stator = [sys.executable, "-I", "-X", "utf8", "-m", "stator"]
    check = [*stator, "check", str(HOME / "graph" / "quad.yaml")]
    for command in (check, [*check, "--json"], [*stator, "--help"]):
        with open("/dev/full", "w") as full:  # noqa: PTH123
            finished = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, check=False)
        said = b"error: cannot write the output: No space left on device\n"
        assert (finished.returncode, finished.stderr) == (2, said)
    for closed in (">&-", "2>&-", "2>/dev/full"):
        line = f"{shlex.join([*stator, 'gen', 'missing.yaml', '-o', '/dev/null'])} {closed}"
        finished = subprocess.run(["bash", "-c", line], capture_output=True, check=False)
        assert (finished.returncode, finished.stdout) == (2, b"")
        assert b"Traceback" not in finished.stderr


def test_a_build_folder_of_another_user(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("os.access", lambda *_: False)
    assert cli.main(["fly", str(HOME / "graph" / "quad.yaml")]) == 2
    error = capsys.readouterr().err
    assert "error: cannot write to the build folder '" in error
    assert "hint: the folder belongs to another user" in error
