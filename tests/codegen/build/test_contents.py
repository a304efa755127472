"""Content decides what is built, whatever the times of the files say."""

from __future__ import annotations

import os
import subprocess
import time
from pathlib import Path

import pytest

from stator.build import contents
from stator.build.contents import STAMP, by_content

NINJA = """\
rule compile
  command = (cat $in ../header) > $out && echo '$out: $in ../header' > $out.d && ! grep broken $in
  depfile = $out.d
  deps = gcc
rule regenerate
  command = touch build.ninja
  generator = 1
build build.ninja: regenerate | ROOT/graph
build program: compile ROOT/source
"""
OLD_NS = 1_600_000_000_000_000_000


@pytest.fixture
def project(tmp_path: Path) -> Path:
    for name in ("source", "header", "graph"):
        write(tmp_path / name, "first ")
    (tmp_path / "build").mkdir()
    (tmp_path / "build" / "build.ninja").write_text(NINJA.replace("ROOT", str(tmp_path)))
    build(tmp_path)
    return tmp_path


def write(file: Path, text: str, time_ns: int = OLD_NS) -> None:
    """With an older time, as `cp -p` restores it."""
    file.write_text(text)
    os.utime(file, ns=(time_ns, time_ns))


def edit(file: Path, text: str) -> None:
    file.write_text(text)


def build(project: Path) -> bool:
    """Whether it succeeded."""
    folder = project / "build"
    with by_content(folder):
        finished = subprocess.run(["ninja"], cwd=folder, check=False, capture_output=True)
    return finished.returncode == 0


def program(project: Path) -> str:
    return (project / "build" / "program").read_text()


@pytest.mark.parametrize("name", ["source", "header"])
def test_a_restored_file_is_built_again(project: Path, name: str) -> None:
    edit(project / name, "second ")
    assert build(project)
    assert "second" in program(project)
    write(project / name, "first ")
    assert build(project)
    assert program(project) == "first first "


def test_an_input_of_cmake_counts_too(project: Path) -> None:
    ninja = project / "build" / "build.ninja"
    edit(project / "graph", "second")
    assert build(project)
    os.utime(ninja)
    before_ns = ninja.stat().st_mtime_ns
    write(project / "graph", "first ")
    assert build(project)
    assert ninja.stat().st_mtime_ns > before_ns


def test_what_a_failed_build_compiled_counts(project: Path) -> None:
    edit(project / "source", "broken ")
    assert not build(project)
    write(project / "source", "first ")
    assert build(project)
    assert program(project) == "first first "


def test_the_first_build_may_fail(tmp_path: Path) -> None:
    for name in ("source", "header", "graph"):
        write(tmp_path / name, "first ")
    (tmp_path / "build").mkdir()
    (tmp_path / "build" / "build.ninja").write_text(NINJA.replace("ROOT", str(tmp_path)))
    edit(tmp_path / "header", "second ")
    assert build(tmp_path)
    edit(tmp_path / "source", "broken ")
    assert not build(tmp_path)
    write(tmp_path / "header", "first ")
    write(tmp_path / "source", "first ")
    assert build(tmp_path)
    assert program(tmp_path) == "first first "


def test_a_file_that_changes_during_its_build(project: Path) -> None:
    """It may have been read before or after: it is built once more."""
    edit(project / "source", "second ")
    folder = project / "build"
    with by_content(folder):
        subprocess.run(["ninja"], cwd=folder, check=True, capture_output=True)
        edit(project / "source", "third ")
        time.sleep(0.01)
        subprocess.run(["ninja"], cwd=folder, check=True, capture_output=True)
        edit(project / "source", "fourth ")
    write(project / "source", "third ")
    assert build(project)
    assert program(project).startswith("third")


def test_without_a_change_nothing_is_built_or_read(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    built_ns = (project / "build" / "program").stat().st_mtime_ns
    stamp = (project / "build" / STAMP).read_bytes()
    monkeypatch.setattr(contents, "_hash", lambda path: pytest.fail(f"reads {path}"))
    monkeypatch.setattr(contents, "_keep", lambda *_: pytest.fail("lists the files again"))
    assert build(project)
    assert (project / "build" / "program").stat().st_mtime_ns == built_ns
    assert (project / "build" / STAMP).read_bytes() == stamp


def test_the_time_of_an_edited_file_stays(project: Path) -> None:
    edit(project / "source", "second ")
    edited_ns = (project / "source").stat().st_mtime_ns
    assert build(project)
    assert (project / "source").stat().st_mtime_ns == edited_ns


def test_a_file_that_cannot_be_touched_means_a_new_build(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    edit(project / "source", "second ")
    assert build(project)
    write(project / "source", "first ")
    monkeypatch.setattr(contents, "_touch", lambda _: False)
    with by_content(project / "build"):
        assert not (project / "build").exists()
