"""What is left of a compiler's output: errors at lines that the user has written."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from stator import HOME
from stator.build.compile_errors import errors_in, kept

if TYPE_CHECKING:
    from pathlib import Path

PORT = HOME / "runtime" / "core" / "stator" / "port.hpp"
TASK = HOME / "build" / "x" / "generated" / "graph_program" / "tasks" / "lean.cpp"


def test_an_error_of_the_user_is_shown_without_what_surrounds_it(tmp_path: Path) -> None:
    output = f"""[1/2] Building CXX object app_lean.dir/lean.cpp.o
FAILED: app_lean.dir/lean.cpp.o
/usr/bin/c++ -DX -I/somewhere -c lean.cpp
{tmp_path}/lean.cpp: In member function 'void Lean::step(LeanPorts&)':
{tmp_path}/lean.cpp:9:11: error: 'tlt' was not declared in this scope
    9 |     if (x < tlt) return;
      |             ^~~
In file included from {tmp_path}/lean.cpp:1:
{PORT}:37:20: note: 'operator->' declared here
   37 |     const Message* operator->() const;
      |                    ^~~~~~~~
ninja: build stopped: subcommand failed.
"""
    assert (
        errors_in(output, tmp_path)
        == f"""{tmp_path}/lean.cpp:9:11: error: \
'tlt' was not declared in this scope
    9 |     if (x < tlt) return;
      |             ^~~"""
    )


def test_an_error_in_a_template_is_shown_where_it_is_used(tmp_path: Path) -> None:
    code = tmp_path / "lean.cpp"
    code.write_text("\n\n    ports.report.publish(report);\n")
    output = f"""{PORT}: In instantiation of 'void Output<Message>::publish(const Other&)':
{code}:3:25:   required from here
{PORT}:228:38: error: static assertion failed: publish expects a function
  228 |         static_assert(sizeof(Other) == 0,
"""
    assert (
        errors_in(output, tmp_path)
        == f"""{code}:3:25: error: publish expects a function
        ports.report.publish(report);
                            ^"""
    )


def test_errors_that_follow_from_the_users_are_not_shown(tmp_path: Path) -> None:
    output = f"""{TASK}:14:1: error: 'Lean' does not name a type
{tmp_path}/lean.hpp:3:1: error: expected ';'
"""
    assert errors_in(output, tmp_path) == f"{tmp_path}/lean.hpp:3:1: error: expected ';'"


def test_an_error_in_generated_code_names_the_users_file(tmp_path: Path) -> None:
    text = "apps/lean/lean.hpp: expected the function `void step(LeanPorts& ports)`"
    output = f"{TASK}:14:15: error: static assertion failed: {text}\n"
    assert errors_in(output, tmp_path) == (
        "apps/lean/lean.hpp: error: expected the function `void step(LeanPorts& ports)`"
    )


def test_other_output_has_no_known_error(tmp_path: Path) -> None:
    assert errors_in("CMake Error: something\n", tmp_path) == ""


def test_the_whole_output_is_kept_where_there_is_room(tmp_path: Path) -> None:
    log = tmp_path / "errors.log"
    assert kept("all of it", tmp_path).startswith("\nhint: ")
    assert log.read_text() == "all of it\n"
    log.unlink()
    log.symlink_to("/dev/full")
    assert kept("all of it", tmp_path) == ""


@pytest.mark.parametrize(
    ("message", "hint"),
    [
        ("'seconds_since_last' was not declared in this scope", '#include "stator/elapsed.hpp"'),
        ("'sqrt' was not declared in this scope", 'stator::math::sqrt is in "stator/scalar.hpp"'),
        ("'atan2' is not a member of 'stator::math'", 'stator::math::atan2 is in "stator/scalar'),
    ],
)
def test_a_name_of_the_runtime_says_its_header(tmp_path: Path, message: str, hint: str) -> None:
    shown = errors_in(f"{tmp_path}/lean.cpp:9:11: error: {message}\n", tmp_path)
    assert f"\nhint: {hint}" in shown


def test_an_unknown_name_has_no_hint(tmp_path: Path) -> None:
    output = f"{tmp_path}/lean.cpp:9:11: error: 'lan' was not declared in this scope\n"
    assert errors_in(output, tmp_path) == output.rstrip()
