"""`./stator test`, on a small project of its own: nothing to compile, so that it is quick."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from stator.testing.run import EVERYTHING, Selection, select

ROOT = Path(__file__).resolve().parents[3]

CMAKE = """
cmake_minimum_required(VERSION 3.21)
project(sample LANGUAGES NONE)
enable_testing()
add_test(NAME Scalar.passes COMMAND ${CMAKE_COMMAND} -E true)
add_test(NAME Scalar.takes_long COMMAND ${CMAKE_COMMAND} -E true)
set_tests_properties(Scalar.takes_long PROPERTIES LABELS long)
add_test(NAME Data.is_skipped COMMAND ${CMAKE_COMMAND} -E false)
set_tests_properties(Data.is_skipped PROPERTIES SKIP_RETURN_CODE 1)
"""
PRESETS = """{"version": 3, "configurePresets":
[{"name": "host", "generator": "Ninja", "binaryDir": "${sourceDir}/build/host"}]}"""
PYTHON_TESTS = """
import os, sys, pytest
def test_data(): assert os.environ["STATOR_DATA"].endswith("/a b/shared/data")
def test_python_skips(): pytest.skip("no recordings")
@pytest.mark.long
def test_python_takes_long(): pass
"""


@pytest.fixture
def project(tmp_path: Path) -> Path:
    root = tmp_path / "a b" / "stator"
    shutil.copytree(ROOT / "codegen" / "stator", root / "codegen" / "stator")
    shutil.copy(ROOT / "pyproject.toml", root)
    (root / "CMakeLists.txt").write_text(CMAKE)
    (root / "CMakePresets.json").write_text(PRESETS)
    (root / "tests" / "maths").mkdir(parents=True)
    (root / "tests" / "test_sample.py").write_text(PYTHON_TESTS)
    return root


def run(project: Path, *arguments: str) -> tuple[int, list[str]]:
    code = "import sys; sys.path.insert(0, sys.argv[1]); from stator.__main__ import main; "
    code += "sys.exit(main(['test', *sys.argv[2:]]))"
    finished = subprocess.run(
        [sys.executable, "-I", "-c", code, str(project / "codegen"), *arguments],
        cwd=project,
        env={"PATH": "/usr/local/bin:/usr/bin:/bin"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    return finished.returncode, finished.stdout.splitlines()


def test_both_kinds_are_counted_in_the_last_line(project: Path) -> None:
    status, lines = run(project)
    assert lines[-3:] == [
        "SKIPPED Data.is_skipped: no reason given",
        "SKIPPED tests/test_sample.py::test_python_skips: no recordings",
        "2 passed, 0 failed, 2 skipped",
    ]
    assert status == 0


def test_long_adds_the_long_ones(project: Path) -> None:
    status, lines = run(project, "--long")
    assert (status, lines[-1]) == (0, "4 passed, 0 failed, 2 skipped")


def test_names_select(project: Path) -> None:
    assert run(project, "Scalar")[1][-1] == "1 passed, 0 failed, 0 skipped"
    assert run(project, "Scalar", "test_data")[1][-1] == "2 passed, 0 failed, 0 skipped"
    assert run(project, "tests/test_sample.py::test_data")[1][-1] == "1 passed, 0 failed, 0 skipped"


def test_no_test_at_all_is_a_failure(project: Path) -> None:
    status, lines = run(project, "no_such_name")
    assert status == 1
    assert lines[-4:] == [
        "no test ran: no test matches no_such_name",
        "hint: add --long to include the long tests",
        "",
        "0 passed, 0 failed, 0 skipped",
    ]


def test_failures_are_shown_and_counted(project: Path) -> None:
    with (project / "CMakeLists.txt").open("a") as file:
        file.write("add_test(NAME Sum.fails COMMAND ${CMAKE_COMMAND} -E cat no_such_file)\n")
        file.write("add_test(NAME Sum.hangs COMMAND ${CMAKE_COMMAND} -E sleep 9)\n")
        file.write("set_tests_properties(Sum.hangs PROPERTIES TIMEOUT 0.1)\n")
    (project / "tests" / "test_broken.py").write_text("import no_such_module\n")
    status, lines = run(project)
    assert status == 1
    output = "\n".join(lines)
    assert "--- Sum.fails: Failed\n" in output
    assert "no_such_file" in output
    assert "--- Sum.hangs: Timeout\n" in output
    assert "No module named 'no_such_module'" in output
    assert lines[-4:] == [
        r"FAILED Sum.fails    again: ./stator test '^Sum\.fails$'",
        r"FAILED Sum.hangs    again: ./stator test '^Sum\.hangs$'",
        "FAILED tests/test_broken.py    again: ./stator test tests/test_broken.py",
        "2 passed, 3 failed, 2 skipped",
    ]


def test_a_build_that_fails_is_a_failed_test(project: Path) -> None:
    with (project / "CMakeLists.txt").open("a") as file:
        file.write("add_custom_target(broken ALL COMMAND ${CMAKE_COMMAND} -E cat no_such_file)\n")
    status, lines = run(project)
    assert status == 1
    assert any("no_such_file" in line for line in lines)
    assert lines[-2:] == [
        "FAILED build    again: ./stator test",
        "0 passed, 1 failed, 0 skipped",
    ]


def test_a_broken_configuration_is_a_failed_test(project: Path) -> None:
    (project / "CMakeLists.txt").write_text("message(FATAL_ERROR wrong)\n")
    status, lines = run(project)
    assert (status, lines[-1]) == (1, "0 passed, 1 failed, 0 skipped")
    assert any("wrong" in line for line in lines)


def test_no_name_selects_everything(tmp_path: Path) -> None:
    assert select(tmp_path, []) == EVERYTHING


def test_a_word_selects_by_name_in_both(tmp_path: Path) -> None:
    assert select(tmp_path, ["rate", "gyro"]) == Selection("rate|gyro", [["-k", "rate or gyro"]])


def test_a_regular_expression_is_for_ctest_alone(tmp_path: Path) -> None:
    assert select(tmp_path, ["^Scalar.*"]) == Selection("^Scalar.*", [])


@pytest.mark.parametrize("word", ["and", "or", "not"])
def test_a_word_of_pytests_expressions_is_for_ctest_alone(tmp_path: Path, word: str) -> None:
    assert select(tmp_path, [word]) == Selection(word, [])


def test_a_path_selects_the_suites_in_it(project: Path) -> None:
    source = project / "tests" / "maths" / "scalar.cpp"
    source.write_text("TEST(Scalar, a) {}\nTEST(Scalar, b) {}\nTEST_P(Table, c) {}\n")
    expected = "(^|[./])(Scalar|Table)[./]"
    for name in ("tests/maths", "tests/maths/scalar.cpp", str(source)):
        assert select(project, [name]) == Selection(expected, [], [source])


def test_a_word_names_the_sources_of_its_tests(project: Path) -> None:
    for name in ("scalar", "table"):
        (project / "tests" / "maths" / f"{name}.cpp").write_text(f"TEST({name}, works) {{}}\n")
    selection = select(project, ["table.wo"])
    assert selection.sources == [project / "tests" / "maths" / "table.cpp"]


def test_a_folder_outside_tests_is_a_word(project: Path) -> None:
    (project / "graph").mkdir()
    assert select(project, ["graph"]) == Selection("graph", [["-k", "graph"]])
