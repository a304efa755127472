"""Builds, runs the C++ tests (ctest) and the Python tests (pytest), and prints one line that counts
both."""

import os
import re
import subprocess
import sys
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from stator import HOME
from stator.build.cmake import lock_of
from stator.build.paths import check_paths
from stator.diagnostics import in_place
from stator.lock import held
from stator.processes import environment as environment_of_builds
from stator.testing.junit import Case, Outcome, read_ctest, read_pytest

PRESET = "host"
PROGRESS_PERIOD_S = 10.0
SLOWEST = 20  # tests that are listed with their times
# Suites and tests as GoogleTest declares them: TEST(Suite, name), TEST_F, TEST_P, TYPED_TEST.
SUITE = re.compile(r"^\s*(?:TYPED_)?TEST(?:_[FP])?\(\s*(\w+)\s*,", re.MULTILINE)
# A failed test in ctest's last list, `12 - name (Timeout)`; its XML lacks the reason.
ENDING = re.compile(r"^\s+\d+ - (.+) \(([^()]+)\)", re.MULTILINE)
# A NAME that pytest -k can read; other characters make a regular expression for ctest only.
# `and`, `or` and `not` are its operators.
KEYWORD = re.compile(r"(?!(?:and|or|not)$)[\w:+\-./\[\]]+")


@dataclass(frozen=True)
class Selection:
    """The tests to run: ctest with this regular expression (empty: not at all), and pytest once
    with each of these lists of arguments."""

    ctest_regex: str
    pytest_runs: list[list[str]]


EVERYTHING = Selection(".", [[]])


def select(root: Path, names: list[str]) -> Selection:
    """Splits NAMEs into paths under tests/, and parts of a test's name."""
    if not names:
        return EVERYTHING
    paths = {name: path for name in names if (path := _path_of_tests(root, name))}
    words = [name for name in names if name not in paths]
    suites = dict.fromkeys(suite for path in paths.values() for suite in _suites(path))
    files = [
        str(path) + "".join(name.partition("::")[1:])
        for name, path in paths.items()
        if _has_python_tests(path)
    ]
    keywords = [word for word in words if KEYWORD.fullmatch(word)]
    runs = [files, ["-k", " or ".join(keywords)] if keywords else []]
    regex = "|".join([*words, *(f"(^|[./]){suite}[./]" for suite in suites)])
    return Selection(regex, [run for run in runs if run])


def _path_of_tests(root: Path, name: str) -> Path | None:
    for folder in (Path.cwd(), root):
        path = (folder / name.partition("::")[0]).resolve()
        if path.exists() and path.is_relative_to(root / "tests"):
            return path
    return None


def _suites(path: Path) -> list[str]:
    files = sorted(path.rglob("*.cpp")) if path.is_dir() else [path] * (path.suffix == ".cpp")
    return [suite for file in files for suite in SUITE.findall(file.read_text(encoding="utf-8"))]


def _has_python_tests(path: Path) -> bool:
    return path.suffix == ".py" or (path.is_dir() and any(path.rglob("test_*.py")))


def run_logged(command: list[str], log: Path, environment: Mapping[str, str]) -> bool:
    """Runs a command with its output in a log; prints a line from time to time, as progress."""
    log.parent.mkdir(parents=True, exist_ok=True)
    due = time.monotonic() + PROGRESS_PERIOD_S
    with (
        log.open("w", encoding="utf-8") as file,
        subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            cwd=HOME,
            env=environment,
        ) as process,
    ):
        for line in process.stdout or ():
            file.write(line)
            if line.strip() and time.monotonic() >= due:
                print(f"  {line.strip()[:96]}", flush=True)
                due = time.monotonic() + PROGRESS_PERIOD_S
    return process.returncode == 0


def build(folder: Path, environment: Mapping[str, str]) -> Case | None:
    """Configures and builds; returns a failed case if that fails."""
    steps = {
        "configure": ["cmake", "--preset", PRESET],
        "build": ["cmake", "--build", str(folder.relative_to(HOME))],
    }
    for name, command in steps.items():
        print(f"{name}: {' '.join(command)}", flush=True)
        log = folder / f"{name}.log"
        try:
            if run_logged(command, log, environment):
                continue
            text = log.read_text(encoding="utf-8")
        except FileNotFoundError as error:
            text = in_place(f"{error}\nhint: install it with ./stator setup\n")
        # Remove ninja's progress lines, so that the errors are visible.
        lines = [line for line in text.splitlines() if not re.match(r"\[\d+/\d+\] ", line)]
        return Case(name, Outcome.FAILED, "\n".join(lines))
    return None


def run_ctest(folder: Path, regex: str, long: bool, environment: Mapping[str, str]) -> list[Case]:
    report, log = folder / "ctest.xml", folder / "ctest.log"
    report.unlink(missing_ok=True)
    command = ["ctest", "--test-dir", str(folder), "--output-junit", str(report)]
    command += ["--output-on-failure", "-j", str(os.cpu_count() or 1), "--tests-regex", regex]
    command += [] if long else ["--label-exclude", "^long$"]
    print("C++ tests: ctest", flush=True)
    succeeded = run_logged(command, log, environment)
    cases = read_ctest(report)
    failed = [case for case in cases if case.outcome is Outcome.FAILED]
    if not succeeded and not failed:
        failed = [Case("ctest", Outcome.FAILED, log.read_text(encoding="utf-8"))]
        cases += failed
    endings = dict(ENDING.findall(log.read_text(encoding="utf-8")))
    for case in failed:
        ending = endings.get(case.name, "Failed")
        print(f"\n--- {case.name}: {ending}\n{case.text}\n    again: {case.rerun}", flush=True)
    return cases


def run_pytest(
    report: Path, arguments: list[str], long: bool, environment: Mapping[str, str]
) -> list[Case]:
    """pytest shows its progress and its failures itself."""
    report.unlink(missing_ok=True)
    command = [sys.executable, "-I", "-X", "utf8", "-m", "pytest", "-q", "--no-header", "-r", ""]
    command += ["--continue-on-collection-errors", "-o", "junit_family=xunit1"]
    command += [f"--junitxml={report}"]
    command += ["-m", "long or not long" if long else "not long", *arguments]
    if not arguments:  # everything: files of tests run side by side, one more than processors
        workers = (os.cpu_count() or 1) + 1  # as the first ones wait most of their time
        command += ["-n", str(workers), "--dist", "loadfile", "--no-loadscope-reorder"]
    print("Python tests: pytest", flush=True)
    finished = subprocess.run(
        command, stdin=subprocess.DEVNULL, cwd=HOME, env=environment, check=False
    )
    cases = read_pytest(report)
    # 0: all passed. 1: some failed. 5: none selected. Else pytest itself broke.
    if finished.returncode not in (0, 1, 5) and all(c.outcome is not Outcome.FAILED for c in cases):
        cases.append(Case("pytest", Outcome.FAILED, f"ended with {finished.returncode}"))
    return cases


def slowest_lines(cases: Iterable[Case]) -> list[str]:
    """The tests that took longest, of both kinds; a build that one waits for is its time."""
    slowest = sorted(cases, key=lambda case: -case.seconds)[:SLOWEST]
    return [f"{case.seconds:7.1f} s  {case.name}" for case in slowest if case.seconds > 0.0]


def closing_lines(cases: Iterable[Case]) -> list[str]:
    """Every skip with its reason, every failure with the way to run it again, and the counts."""
    by_outcome: dict[Outcome, list[Case]] = {outcome: [] for outcome in Outcome}
    for case in cases:
        by_outcome[case.outcome].append(case)
    return [
        *(f"SKIPPED {c.name}: {' '.join(c.text.split())}" for c in by_outcome[Outcome.SKIPPED]),
        *(f"FAILED {c.name}    again: {c.rerun}" for c in by_outcome[Outcome.FAILED]),
        ", ".join(f"{len(by_outcome[outcome])} {outcome.value}" for outcome in Outcome),
    ]


def environment_of_tests(root: Path) -> dict[str, str]:
    environment = environment_of_builds()
    environment.setdefault("STATOR_DATA", str(root.parent / "shared" / "data"))
    # Of each build; several run at once.
    environment.setdefault("CMAKE_BUILD_PARALLEL_LEVEL", str(os.cpu_count() or 1))
    return environment


def run_all(names: list[str], long: bool) -> list[Case]:
    """Of two at once in one checkout the second waits: they share what is built, and reports."""
    folder = HOME / "build" / PRESET
    check_paths([HOME])
    with held(lock_of(folder), "builds and tests"):
        return _run_all(folder, names, long)


def _run_all(folder: Path, names: list[str], long: bool) -> list[Case]:
    environment = environment_of_tests(HOME)
    failure = build(folder, environment)
    if failure:
        print(f"\n--- {failure.name} failed:\n{failure.text}", flush=True)
        return [failure]
    selection = select(HOME, names)
    cases: list[Case] = []
    if selection.ctest_regex:
        cases += run_ctest(folder, selection.ctest_regex, long, environment)
    for number, arguments in enumerate(selection.pytest_runs):
        cases += run_pytest(folder / f"pytest{number}.xml", arguments, long, environment)
    return cases
