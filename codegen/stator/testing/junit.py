"""Reads the JUnit XML of ctest and pytest, so that all tests count in the same way."""

import re
import shlex
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, replace
from enum import Enum
from pathlib import Path

from stator.diagnostics import in_place


class Outcome(Enum):
    PASSED = "passed"
    FAILED = "failed"
    SKIPPED = "skipped"


@dataclass(frozen=True)
class Case:
    """One test. `text`: the whole output of a failure, or the reason of a skip. `selector`: the
    NAME that runs it alone with `./stator test`."""

    name: str
    outcome: Outcome
    text: str = ""
    selector: str = ""
    seconds: float = 0.0

    @property
    def rerun(self) -> str:
        again = "./stator test" + (f" {shlex.quote(self.selector)}" if self.selector else "")
        return in_place(again)


def read_ctest(path: Path) -> list[Case]:
    return [_timed(_ctest_case(element), element) for element in _elements(path)]


def read_pytest(path: Path) -> list[Case]:
    """Needs `junit_family=xunit1`, which names the file of each test."""
    return [_timed(_pytest_case(element), element) for element in _elements(path)]


def _timed(case: Case, element: ElementTree.Element) -> Case:
    return replace(case, seconds=float(element.get("time") or 0.0))


def _elements(path: Path) -> list[ElementTree.Element]:
    return list(ElementTree.parse(path).iter("testcase")) if path.exists() else []


def _ctest_case(element: ElementTree.Element) -> Case:
    name, status = element.get("name", ""), element.get("status")
    selector = f"^{re.escape(name)}$"
    output = element.findtext("system-out", "").strip()
    skipped = element.find("skipped")
    message = skipped.get("message", "") if skipped is not None else ""
    if status == "run":
        return Case(name, Outcome.PASSED, selector=selector)
    # Any other test that did not run should have run (a missing program, for example): it failed.
    if status == "disabled" or message.startswith("SKIP_"):
        return Case(name, Outcome.SKIPPED, _reason_of_skip(output), selector)
    return Case(name, Outcome.FAILED, output or message or "(no output)", selector)


def _reason_of_skip(output: str) -> str:
    """GoogleTest prints `file:line: Skipped`, the reason, and a line with `[  SKIPPED ]`."""
    google = re.search(r": Skipped\n(.*?)\[  SKIPPED \]", output, re.DOTALL)
    return (google[1].strip() if google else output) or "no reason given"


def _pytest_case(element: ElementTree.Element) -> Case:
    name = _node_id(element)
    for problem in [*element.findall("failure"), *element.findall("error")]:
        return Case(name, Outcome.FAILED, problem.text or problem.get("message") or "", name)
    skipped = element.find("skipped")
    if skipped is not None:
        return Case(name, Outcome.SKIPPED, skipped.get("message") or "no reason given", name)
    return Case(name, Outcome.PASSED, selector=name)


def _node_id(element: ElementTree.Element) -> str:
    """`tests/test_a.py::TestB::test_c[1]`, from the dotted class name `tests.test_a.TestB`."""
    file, dotted = element.get("file", "tests"), element.get("classname", "")
    if not dotted:  # a file that could not be read at all
        return file
    module = file.removesuffix(".py").replace("/", ".")
    classes = dotted.removeprefix(module).split(".")
    return "::".join([file, *filter(None, classes), element.get("name", "")])
