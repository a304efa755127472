"""Counting from JUnit XML. The samples are cut from what CMake 3.25's ctest (with GoogleTest 1.12)
and pytest 9.2 wrote: `ctest --output-junit`, `pytest -o junit_family=xunit1 --junitxml`."""

from pathlib import Path

import pytest

from stator.testing.junit import Case, Outcome, read_ctest, read_pytest
from stator.testing.run import closing_lines

CTEST = r"""<?xml version="1.0" encoding="UTF-8"?>
<testsuite name="(empty)" tests="8" failures="3" disabled="1" skipped="3" time="0">
  <testcase name="Scalar.passes" classname="Scalar.passes" time="0.003" status="run">
    <system-out>[  PASSED  ] 1 test.
</system-out></testcase>
  <testcase name="Scalar.fails" classname="Scalar.fails" time="0.003" status="fail">
    <failure message=""/>
    <system-out>t.cpp:4: Failure
one is not two
</system-out></testcase>
  <testcase name="late" classname="late" time="0.503" status="fail">
    <failure message=""/><system-out></system-out></testcase>
  <testcase name="missing" classname="missing" time="0" status="notrun">
    <skipped message="Unable to find executable"/>
    <system-out>Unable to find executable: no_such_program</system-out></testcase>
  <testcase name="Data.skipped" classname="Data.skipped" time="0.004" status="notrun">
    <skipped message="SKIP_REGULAR_EXPRESSION_MATCHED"/>
    <system-out>[ RUN      ] Data.skipped
/stator/t.cpp:5: Skipped
no recordings in
/nowhere
[  SKIPPED ] Data.skipped (0 ms)
[  SKIPPED ] 1 test, listed below:
[  SKIPPED ] Data.skipped
</system-out></testcase>
  <testcase name="Data.silent" classname="Data.silent" time="0.004" status="notrun">
    <skipped message="SKIP_REGULAR_EXPRESSION_MATCHED"/>
    <system-out>/stator/t.cpp:6: Skipped

[  SKIPPED ] Data.silent (0 ms)
</system-out></testcase>
  <testcase name="Crash.now" classname="Crash.now" time="0" status="disabled">
    <system-out>Disabled</system-out></testcase>
  <testcase name="Some/P.even/1" classname="Some/P.even/1" time="0.003" status="run"/>
</testsuite>"""

PYTEST = r"""<?xml version="1.0" encoding="utf-8"?>
<testsuites name="pytest tests">
<testsuite name="pytest" errors="2" failures="1" skipped="1" tests="6">
<testcase classname="" name="tests.x.test_q" file="tests/x/test_q.py" time="0.000">
  <error message="collection failure">ImportError while importing</error></testcase>
<testcase classname="tests.x.test_p" name="test_ok" file="tests/x/test_p.py" line="3" time="0.0" />
<testcase classname="tests.x.test_p.TestGroup" name="test_bad[a b]" file="tests/x/test_p.py">
  <failure message="assert 'a b' == 1">self = TestGroup</failure></testcase>
<testcase classname="tests.x.test_p" name="test_skip" file="tests/x/test_p.py" line="7">
  <skipped type="pytest.skip" message="no recordings in X">/x/test_p.py:8: no</skipped></testcase>
<testcase classname="tests.x.test_p" name="test_error" file="tests/x/test_p.py" line="11">
  <error message="failed on setup with &quot;ValueError: x&quot;">@pytest.fixture</error></testcase>
<testcase classname="tests.x.test_p" name="test_last" file="tests/x/test_p.py" line="13" />
</testsuite></testsuites>"""


@pytest.fixture
def ctest_cases(tmp_path: Path) -> list[Case]:
    (tmp_path / "report.xml").write_text(CTEST)
    return read_ctest(tmp_path / "report.xml")


@pytest.fixture
def pytest_cases(tmp_path: Path) -> list[Case]:
    (tmp_path / "report.xml").write_text(PYTEST)
    return read_pytest(tmp_path / "report.xml")


def texts(cases: list[Case], outcome: Outcome) -> dict[str, str]:
    return {case.name: case.text for case in cases if case.outcome is outcome}


def test_ctest_outcomes(ctest_cases: list[Case]) -> None:
    assert list(texts(ctest_cases, Outcome.PASSED)) == ["Scalar.passes", "Some/P.even/1"]
    assert texts(ctest_cases, Outcome.FAILED) == {
        "Scalar.fails": "t.cpp:4: Failure\none is not two",
        "late": "(no output)",
        "missing": "Unable to find executable: no_such_program",
    }
    assert texts(ctest_cases, Outcome.SKIPPED) == {
        "Data.skipped": "no recordings in\n/nowhere",
        "Data.silent": "no reason given",
        "Crash.now": "Disabled",
    }


def test_pytest_outcomes(pytest_cases: list[Case]) -> None:
    assert len(texts(pytest_cases, Outcome.PASSED)) == 2
    assert texts(pytest_cases, Outcome.FAILED) == {
        "tests/x/test_q.py": "ImportError while importing",
        "tests/x/test_p.py::TestGroup::test_bad[a b]": "self = TestGroup",
        "tests/x/test_p.py::test_error": "@pytest.fixture",
    }
    assert texts(pytest_cases, Outcome.SKIPPED) == {
        "tests/x/test_p.py::test_skip": "no recordings in X"
    }


def test_a_missing_report_has_no_cases(tmp_path: Path) -> None:
    assert read_ctest(tmp_path / "none.xml") == []


def test_closing_lines(ctest_cases: list[Case], pytest_cases: list[Case]) -> None:
    assert closing_lines([*ctest_cases, *pytest_cases]) == [
        "SKIPPED Data.skipped: no recordings in /nowhere",
        "SKIPPED Data.silent: no reason given",
        "SKIPPED Crash.now: Disabled",
        "SKIPPED tests/x/test_p.py::test_skip: no recordings in X",
        r"FAILED Scalar.fails    again: ./stator test '^Scalar\.fails$'",
        "FAILED late    again: ./stator test '^late$'",
        "FAILED missing    again: ./stator test '^missing$'",
        "FAILED tests/x/test_q.py    again: ./stator test tests/x/test_q.py",
        "FAILED tests/x/test_p.py::TestGroup::test_bad[a b]"
        "    again: ./stator test 'tests/x/test_p.py::TestGroup::test_bad[a b]'",
        "FAILED tests/x/test_p.py::test_error"
        "    again: ./stator test tests/x/test_p.py::test_error",
        "4 passed, 6 failed, 4 skipped",
    ]


def test_closing_line_of_nothing() -> None:
    assert closing_lines([]) == ["0 passed, 0 failed, 0 skipped"]
