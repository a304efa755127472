"""Double precision on a chip without instructions for it: refused with who computes, or allowed."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import pytest
from tests.emulation.firmware_tools import needs_toolchain

from stator import __main__ as cli

if TYPE_CHECKING:
    from pathlib import Path

WHY = "The sums of a day are long."
# Both also in a constructor, which runs before the flight.
SUMS = """#pragma once
#include "sums_ports.hpp"
#include "stator/scalar.hpp"

namespace stator::apps::sums {

class Sums {
  public:
    void step(SumsPorts& ports) {
        const double sum = plus_a_third(ports.params->gain);
        ports.count.publish([&] { return Count{.value = static_cast<uint32_t>(sum)}; });
    }

  private:
    double plus_a_third(float value) { return sum_ += static_cast<double>(value) / 3.0; }
    double sum_ = math::cos(0.5);
};

}  // namespace stator::apps::sums
"""
ANGLES = """#pragma once
#include "angles_ports.hpp"
#include "stator/scalar.hpp"

namespace stator::apps::angles {

class Angles {
  public:
    void step(AnglesPorts& ports) {
        const double sine = math::sin(static_cast<double>(ports.params->gain));
        ports.count.publish([&] { return Count{.value = sine > half_ ? 1U : 0U}; });
    }

  private:
    double half_ = math::cos(1.0);
};

}  // namespace stator::apps::angles
"""
GRAPH = """board: qemu_f405
nodes:
  left: {app: sums, trigger: {every: 10 ms}, outputs: {count: left_count}}
  right: {app: angles, trigger: {every: 10 ms}, outputs: {count: right_count}}
"""


def project(folder: Path) -> Path:
    """A graph with two apps that compute in double precision."""
    (folder / "messages").mkdir()
    (folder / "messages" / "Count.yaml").write_text(
        "doc: A number.\nfields: {value: {type: uint32, doc: It.}}\n"
    )
    for app, code in {"sums": SUMS, "angles": ANGLES}.items():
        (folder / "apps" / app).mkdir(parents=True)
        (folder / "apps" / app / f"{app}.hpp").write_text(code)
        (folder / "apps" / app / f"{app}.yaml").write_text(
            "doc: It computes.\noutputs: {count: {message: Count, doc: A result.}}\n"
            "params: {gain: {type: float, default: 1, doc: What goes in.}}\n"
        )
    graph = folder / "double_precision.yaml"
    graph.write_text(GRAPH)
    return graph


def allow(folder: Path, app: str) -> None:
    with (folder / "apps" / app / f"{app}.yaml").open("a") as interface:
        interface.write(f"double_precision: {WHY}\n")


def test_it_is_refused_with_function_and_node_until_an_interface_says_why(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    needs_toolchain()
    graph = project(tmp_path)
    allow(tmp_path, "angles")
    monkeypatch.chdir(tmp_path)
    assert cli.main(["build", str(graph)]) == 2
    why = "double precision, which this chip has no instructions for"
    hint = (
        "hint: compute in float (1.0F, not 1.0), and use the functions of stator::math; if only "
        "double is precise enough, write `double_precision: WHY` in apps/sums/sums.yaml"
    )
    assert capsys.readouterr().err.splitlines() == [
        f"apps/sums/sums.hpp:11: error: stator::apps::sums::Sums::step of node 'left' calls "
        f"__aeabi_d2uiz: {why}",
        hint,
        "apps/sums/sums.hpp:15: error: stator::apps::sums::Sums::plus_a_third of node 'left' "
        f"calls __aeabi_dadd, __aeabi_ddiv, __aeabi_f2d: {why}",
        hint,
    ]

    allow(tmp_path, "sums")
    assert cli.main(["build", str(graph)]) == 0
    shown = capsys.readouterr().out
    assert f"\ndouble precision in software: node left, 2 lines: {WHY}\n" in shown
    assert f"\ndouble precision in software: node right, 2 lines: {WHY}\n" in shown

    assert cli.main(["build", str(graph), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["double_precision"] == {
        "left": {"lines": 2, "why": WHY},
        "right": {"lines": 2, "why": WHY},
    }
