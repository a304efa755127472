"""What nodes must not call or keep is found in their object files, at its line."""

from __future__ import annotations

import subprocess
from typing import TYPE_CHECKING

import pytest

from stator import __main__ as cli
from stator.build.app_rules import errors_of, forbidden

if TYPE_CHECKING:
    from pathlib import Path

CODE = """#include <cmath>
#include <ctime>
#include <vector>
#include "other.hpp"
namespace stator::apps::own {
int total = 0;
const int kTable[] = {1, 2, 3};
constexpr float kGain = 2.0F;
float step(float x, int n) {
    static int count = 0;  // and again: count
    count += n + kTable[n];
    total += count;
    float* const more = new float[static_cast<unsigned>(n)];
    more[0] = std::sin(x) * kGain;
    std::vector<float> list(7, x);
    return more[n] + list.at(static_cast<unsigned>(n)) + static_cast<float>(time(nullptr));
}
}
"""


@pytest.fixture
def compiled(tmp_path: Path) -> tuple[Path, Path]:
    """The object and the folder of an app."""
    folder = tmp_path / "apps" / "own"
    folder.mkdir(parents=True)
    (folder / "other.hpp").write_text("#pragma once\n")
    (folder / "own.cpp").write_text(CODE)
    result = tmp_path / "own.o"
    command = ["g++", "-std=c++20", "-O2", "-g1", "-fno-exceptions", "-fno-threadsafe-statics"]
    subprocess.run([*command, "-c", folder / "own.cpp", "-o", result], check=True)
    return result, folder


def test_each_is_named_with_its_line(compiled: tuple[Path, Path]) -> None:
    found = errors_of([compiled[0]], [compiled[1]])
    shown = {(error.mark.line, error.message) for error in found}
    assert shown >= {
        (6, "own has the global variable 'total'"),
        (10, "own has the function static 'count'"),
        (13, "own uses the heap"),
        (14, "own uses sinf of libm, whose bits differ between machines"),
        (15, "own uses the heap"),
        (16, "own uses exceptions"),
        (16, "own uses a clock"),
    }
    assert not any("kTable" in message or "kGain" in message for _, message in shown)
    hints = {error.hint for error in found}
    assert "use stator::math::sin of stator/scalar.hpp" in hints


def test_code_of_others_is_not_judged(compiled: tuple[Path, Path], tmp_path: Path) -> None:
    assert errors_of([compiled[0]], [tmp_path / "apps" / "another"]) == []


@pytest.mark.parametrize("symbol", ["memcpy", "abort", "_ZN6stator4math3sinEf", "sinking", "newer"])
def test_other_symbols_are_allowed(symbol: str) -> None:
    assert forbidden(symbol) is None


@pytest.mark.parametrize("name", ["cosf", "tan", "powf", "sqrt", "floorf", "round"])
def test_a_function_of_libm_has_one_of_ours(name: str) -> None:
    call = forbidden(name)
    assert call is not None
    assert call.hint.startswith(f"use stator::math::{name.removesuffix('f')} of stator/")


IDLE = """#include "idle_ports.hpp"
namespace stator::apps::idle {
struct Idle {
    void step(IdlePorts&) {
        static uint32_t count = 0;
        ++count;
    }
};
}  // namespace stator::apps::idle
"""


def test_check_code_says_what_a_node_must_not_do(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "apps" / "idle").mkdir(parents=True)
    (tmp_path / "apps" / "idle" / "idle.yaml").write_text("doc: It counts.\n")
    header = tmp_path / "apps" / "idle" / "idle.hpp"
    header.write_text(IDLE)
    graph = tmp_path / "idle.yaml"
    graph.write_text("board: sitl\nnodes: {idle: {trigger: {every: 1 s}, priority: 3}}\n")
    assert cli.main(["check", "idle.yaml"]) == 0
    assert cli.main(["check", "idle.yaml", "--code"]) == 2
    error = capsys.readouterr().err
    assert "-std=" not in error
    assert "apps/idle/idle.hpp:5:25: error: idle has the function static 'count'" in error
    header.write_text(IDLE.replace("static uint32_t count", "uint32_t count"))
    monkeypatch.setenv("STATOR_VERBOSE", "off")  # which is restored after the test
    assert cli.main(["check", "idle.yaml", "--code", "--verbose"]) == 0
    assert "-std=" in capsys.readouterr().err  # the compiler's command lines
