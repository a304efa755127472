"""`./stator completion`: what a real bash offers; for other shells, that each command is known."""

from __future__ import annotations

import shlex
import subprocess
from pathlib import Path

import pytest

from stator import HOME
from stator import __main__ as cli
from stator.__main__ import COMMANDS
from stator.commands.completion import SHELLS


def script(shell: str, capsys: pytest.CaptureFixture[str]) -> str:
    assert cli.main(["completion", shell]) == 0
    return capsys.readouterr().out


@pytest.fixture
def bash_script(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Path:
    file = tmp_path / "stator.bash"
    file.write_text(script("bash", capsys), encoding="utf-8")
    return file


def bash(script: Path, code: str) -> list[str]:
    """The lines that code prints in a bash that has read the script."""
    command = ["bash", "--norc", "-c", f"source {shlex.quote(str(script))} && {code}"]
    finished = subprocess.run(command, capture_output=True, text=True, check=True, cwd=HOME)
    return finished.stdout.splitlines()


def offers(script: Path, *words: str) -> list[str]:
    """What bash offers for the last word of a command line."""
    (registered,) = bash(script, "complete -p stator")
    function = registered.split()[registered.split().index("-F") + 1]
    line = shlex.join(words)
    code = f"COMP_WORDS=({line}) COMP_CWORD={len(words) - 1}; {function}"
    arguments = shlex.join([words[0], words[-1], words[-2]])
    return bash(script, f'{code} {arguments}; printf "%s\\n" "${{COMPREPLY[@]}}"')


def test_every_command_is_offered(bash_script: Path) -> None:
    assert offers(bash_script, "./stator", "") == [command.name for command in COMMANDS]
    assert offers(bash_script, "./stator", "compl") == ["completion"]


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["check", "--pl"], ["--plan"]),
        (["fly", "--gusts", "m"], ["moderate"]),
        (["build", "--board", "fm"], ["fmu_v2"]),
        (["check", "graph/quad.y"], ["graph/quad.yaml"]),
        (["fly", "--mission", "graph/missions/sq"], ["graph/missions/square.yaml"]),
        (["new", "gr"], ["graph"]),
        (["completion", ""], list(SHELLS)),
        (["explain", "graph/quad.yaml", "REA"], []),  # a node is not a file
    ],
)
def test_arguments_are_offered(bash_script: Path, words: list[str], expected: list[str]) -> None:
    assert [offer for offer in offers(bash_script, "stator", *words) if offer] == expected


@pytest.mark.parametrize("shell", SHELLS)
def test_each_shell_knows_every_command(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    text = script(shell, capsys)
    assert all(command.help in text or command.name in text for command in COMMANDS)
    assert "--gusts" in text or "-l gusts" in text


def test_an_unknown_shell_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        cli.main(["completion", "csh"])
    assert "choose from 'bash', 'zsh', 'fish'" in capsys.readouterr().err
