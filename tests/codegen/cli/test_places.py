"""Commands and projects in other folders, with odd names, and with variables that mean others."""

import contextlib
import json
import os
import shlex
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from stator import HOME
from stator import __main__ as cli
from stator.build.cmake import short_name
from stator.build.paths import REFUSED, check_paths
from stator.diagnostics import BuildFailed, entry, in_place, shown_argument
from stator.processes import environment

GRAPH = """
board: sitl
nodes:
  ramp: {trigger: {every: 100 ms}, priority: 5, outputs: {value: value}}
  logger: {trigger: {every: 5 ms}, priority: 2, outputs: {block: log_block}}
  log_sink:
    device: log_storage
    trigger: {topic: log_block}
    priority: 1
    inputs: {block: log_block}
"""
FILES = {
    "messages/Value.yaml": "doc: A number.\nfields: {value: {type: float, doc: It.}}\n",
    "apps/ramp/ramp.yaml": "doc: Counts.\noutputs: {value: {message: Value, doc: It.}}\n",
    "apps/ramp/ramp.hpp": """#pragma once
#include "ramp_ports.hpp"
namespace stator::apps::ramp {
float after(float value);
struct Ramp {
    float next_ = 0.0F;
    void step(RampPorts& ports) {
        next_ = after(next_);
        ports.value.publish([&] { return Value{.value = next_}; });
    }
};
}  // namespace stator::apps::ramp
""",
    "apps/ramp/ramp.cpp": """#include "ramp.hpp"
namespace stator::apps::ramp {
float after(float value) { return value + 1.0F; }
}  // namespace stator::apps::ramp
""",
}
# Each of these once changed what is built, or broke it.
VARIABLES = {
    "CXXFLAGS": "-O3 -funsafe-math-optimizations",
    "CXX": "/nowhere/c++",
    "LDFLAGS": "--no-such-flag",
    "CPATH": "/nowhere",
    "GCC_EXEC_PREFIX": "/nowhere/",
    "CMAKE_GENERATOR": "No Such Generator",
    "CMAKE_BUILD_TYPE": "Debug",
    "CCACHE_PREFIX": "/nowhere/ccache",
    "PYTHONHOME": "/opt/other",
    "PYTHONPATH": "/nowhere",
}


def test_only_what_is_listed_reaches_a_build(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in VARIABLES.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setenv("STATOR_DATA", "/data")
    passed = environment()
    assert not VARIABLES.keys() & passed.keys()
    assert passed["PATH"] == os.environ["PATH"]
    assert passed["STATOR_DATA"] == "/data"


def stator(*words: str, folder: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-I", "-X", "utf8", "-m", "stator", *words]
    return subprocess.run(
        command,
        cwd=folder,
        env=os.environ | VARIABLES | {"STATOR_ENTRY": ""},
        capture_output=True,
        text=True,
        check=False,
    )


def test_a_project_in_a_folder_with_an_odd_name(tmp_path: Path) -> None:
    """Built with variables that mean other builds, flown, and replayed with the printed command."""
    project = tmp_path / "a b'(){}&%@!,+=~^:é漢"
    for name, text in FILES.items():
        file = project / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    graph = project / "ramp_alone.yaml"
    graph.write_text(GRAPH, encoding="utf-8")
    other = tmp_path / "elsewhere"
    other.mkdir()
    log = other / "-[a;b] $c.ulg"
    words = ["fly", f"../{project.name}/{graph.name}", "--duration", "1", f"--output=./{log.name}"]
    flown = stator(*words, folder=other)
    assert flown.returncode == 0, flown.stderr
    cache = HOME / "build" / f"{short_name(graph)}-sitl-STATOR_RECORDING" / "CMakeCache.txt"
    assert "\nCMAKE_CXX_FLAGS:STRING=\n" in cache.read_text(encoding="utf-8")

    line = next(line for line in flown.stdout.splitlines() if " replay " in line)
    following = shlex.split(line.partition("bit for bit: ")[2])
    assert following[0] == str(HOME / "stator")
    replayed = stator(*following[following.index("replay") :], folder=other)
    assert (replayed.returncode, replayed.stdout.splitlines()[0]) == (
        0,
        "replay of ramp_alone on sitl: equal",
    ), replayed.stderr


@pytest.mark.parametrize("character", [*REFUSED, "\n"])
def test_what_cmake_cannot_take_is_refused_by_name(character: str) -> None:
    with pytest.raises(BuildFailed, match="cannot build in '/a") as refused:
        check_paths([Path("/good"), Path(f"/a{character}b")])
    named = "a line break" if character == "\n" else character
    assert f"do not take {named} in a path\nhint: rename the folder" in str(refused.value)


def test_such_a_project_is_refused_before_anything_is_built(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    graph = tmp_path / "a[b]" / "timer.yaml"
    shutil.copytree(HOME / "graph" / "examples", graph.parent)
    assert cli.main(["fly", str(graph)]) == 2
    assert "do not take [ ] in a path" in capsys.readouterr().err
    assert not (HOME / "build" / f"{short_name(graph)}-sitl").exists()


def test_commands_are_named_as_they_are_typed_here(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("STATOR_ENTRY", "")
    monkeypatch.chdir(HOME)
    assert entry() == "./stator"
    monkeypatch.chdir(HOME / "graph")
    assert entry() == str(HOME / "stator")
    monkeypatch.setenv("STATOR_ENTRY", "../stator")
    assert in_place("hint: ./stator fly; ../stator") == "hint: ../stator fly; ../stator"
    monkeypatch.chdir(tmp_path)
    assert entry() == str(HOME / "stator"), "called from elsewhere: there is none at ../stator"
    (tmp_path / "stator").symlink_to(HOME / "stator")
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    monkeypatch.setenv("STATOR_ENTRY", f"{tmp_path}/stator")
    assert entry() == "stator"
    assert cli.main(["plot", "missing.ulg"]) == 2
    assert "hint: stator fly writes a log" in capsys.readouterr().err
    assert shown_argument(tmp_path / "-x y") == "'./-x y'"


@pytest.mark.parametrize("end", ["json", "truth"])
def test_a_log_is_not_called_like_what_lies_beside_it(
    end: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        cli.main(["fly", "-o", f"a.{end}"])
    assert f"a log cannot end in .{end}" in capsys.readouterr().err


# Starts what would never end, and says which process it is.
PARENT = """
import sys, time
from stator.processes import start
print(start(["sleep", "infinity"]).pid, flush=True)
time.sleep(3600)
"""


def test_what_is_started_ends_with_a_killed_parent() -> None:
    command = [sys.executable, "-I", "-c", PARENT]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        child = Path("/proc", parent.stdout.readline().strip())
        parent.kill()
    with contextlib.suppress(FileNotFoundError, ProcessLookupError):  # it is gone
        while ") Z" not in (child / "stat").read_text(encoding="utf-8"):  # no parent reads its end
            time.sleep(0.01)


def test_a_kept_report_of_another_log_names_no_graph(tmp_path: Path) -> None:
    from stator.commands.replay import kept_graph
    from stator.flight.recording import Recording

    recording = Recording(tmp_path / "a.ulg", b"ULog")
    assert kept_graph(recording) is None
    report = {"log_sha256": "0" * 64, "graph_file": "/g.yaml"}
    (tmp_path / "a.json").write_text(json.dumps(report), encoding="utf-8")
    assert kept_graph(recording) is None
    (tmp_path / "a.json").write_text("[]", encoding="utf-8")
    assert kept_graph(recording) is None
