"""`./stator --version`: the version, the commit if it is known, and the schema."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from stator import __main__ as cli
from stator import version


def git(folder: Path, *arguments: str) -> str:
    identity = ["-c", "user.name=a", "-c", "user.email=a@b", "-c", "commit.gpgsign=false"]
    command = ["git", "-C", str(folder), *identity, *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


@pytest.fixture
def checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A checkout with one commit and one tag, in place of this one."""
    home = tmp_path / "a b"
    home.mkdir()
    git(home, "init", "--quiet")
    (home / "stator").write_text("one")
    git(home, "add", "stator")
    git(home, "commit", "--quiet", "-m", "one")
    git(home, "tag", "v0")
    monkeypatch.setattr(version, "HOME", home)
    return home


def shown(capsys: pytest.CaptureFixture[str]) -> str:
    with pytest.raises(SystemExit, match="0"):
        cli.main(["--version"])
    return capsys.readouterr().out


def line(commit: str) -> str:
    return f"stator {version.VERSION}, commit {commit}, schema {version.SCHEMA_VERSION}\n"


def test_it_shows_the_commit(checkout: Path, capsys: pytest.CaptureFixture[str]) -> None:
    commit = git(checkout, "rev-parse", "HEAD")[:12]
    assert shown(capsys) == line(commit)
    (checkout / "stator").write_text("two")
    assert shown(capsys) == line(f"{commit}, modified")


def test_it_works_without_git(
    checkout: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(checkout))
    assert shown(capsys) == line("unknown")


def test_a_commit_of_another_project_is_not_shown(
    checkout: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    copy = checkout / "third_party" / "stator"
    copy.mkdir(parents=True)
    monkeypatch.setattr(version, "HOME", copy)
    assert shown(capsys) == line("unknown")


def test_the_schema_shows_its_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["schema"]) == 0
    assert f'"$comment": "schema {version.SCHEMA_VERSION}"' in capsys.readouterr().out
