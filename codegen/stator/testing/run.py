"""Builds, runs the C++ tests (ctest) and the Python tests (pytest), and prints one line that counts
both."""

import os
import re
import subprocess
import sys
import time
from collections.abc import Iterable, Mapping
from pathlib import Path

from stator import HOME
from stator.build.cmake import lock_of
from stator.build.contents import by_content
from stator.build.paths import check_paths
from stator.diagnostics import in_place
from stator.lock import held
from stator.processes import environment as environment_of_builds
from stator.testing.junit import Case, Outcome, read_ctest, read_pytest
from stator.testing.selection import EVERYTHING, NOT_BUILT, Selection, select, targets_of

PRESET = "host"
PROGRESS_PERIOD_S = 10.0
SLOWEST = 20  # tests that are listed with their times
# A failed test in ctest's last list, `12 - name (Timeout)`; its XML lacks the reason.
ENDING = re.compile(r"^\s+\d+ - (.+) \(([^()]+)\)", re.MULTILINE)


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


def build(folder: Path, selection: Selection, environment: Mapping[str, str]) -> Case | None:
    """Configures, and builds what the selection needs; returns a failed case if that fails."""
    failure = _run_step("configure", ["cmake", "--preset", PRESET], folder, environment)
    if failure is not None:
        return failure
    command = ["cmake", "--build", str(folder.relative_to(HOME))]
    if selection == EVERYTHING:
        return _run_step("build", command, folder, environment)
    targets = targets_of(selection, folder) if selection.ctest_regex else []
    if not targets:
        return None
    return _run_step("build", [*command, "--target", *targets], folder, environment)


def _run_step(
    name: str, command: list[str], folder: Path, environment: Mapping[str, str]
) -> Case | None:
    print(f"{name}: {' '.join(command)}", flush=True)
    log = folder / f"{name}.log"
    try:
        if run_logged(command, log, environment):
            return None
        text = log.read_text(encoding="utf-8")
    except FileNotFoundError as error:
        text = in_place(f"{error}\nhint: install it with ./stator setup\n")
    # Remove ninja's progress lines, so that the errors are visible.
    lines = [line for line in text.splitlines() if not re.match(r"\[\d+/\d+\] ", line)]
    return Case(name, Outcome.FAILED, "\n".join(lines))


def run_ctest(folder: Path, regex: str, long: bool, environment: Mapping[str, str]) -> list[Case]:
    report, log = folder / "ctest.xml", folder / "ctest.log"
    report.unlink(missing_ok=True)
    command = ["ctest", "--test-dir", str(folder), "--output-junit", str(report)]
    command += ["--output-on-failure", "-j", str(os.cpu_count() or 1), "--tests-regex", regex]
    command += ["--exclude-regex", NOT_BUILT]
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
    report: Path,
    arguments: list[str],
    long: bool,
    environment: Mapping[str, str],
    root: Path = HOME,
) -> list[Case]:
    """pytest shows its progress and its failures itself."""
    report.unlink(missing_ok=True)
    command = [sys.executable, "-I", "-X", "utf8", "-m", "pytest", "-q", "--no-header", "-r", ""]
    command += ["--continue-on-collection-errors", "-o", "junit_family=xunit1"]
    command += [f"--junitxml={report}"]
    command += ["-m", "long or not long" if long else "not long", *arguments]
    if not arguments:  # everything: files of tests run side by side, two for each processor, as
        workers = 2 * (os.cpu_count() or 1)  # many wait: for a lock, an emulator, real time
        command += ["-n", str(workers), "--dist", "loadfile", "--no-loadscope-reorder"]
    print("Python tests: pytest", flush=True)
    finished = subprocess.run(
        command, stdin=subprocess.DEVNULL, cwd=root, env=environment, check=False
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
    selection = select(HOME, names)
    with by_content(folder):
        failure = build(folder, selection, environment)
    if failure:
        print(f"\n--- {failure.name} failed:\n{failure.text}", flush=True)
        return [failure]
    cases: list[Case] = []
    if selection.ctest_regex:
        cases += run_ctest(folder, selection.ctest_regex, long, environment)
    for number, arguments in enumerate(selection.pytest_runs):
        cases += run_pytest(folder / f"pytest{number}.xml", arguments, long, environment)
    return cases
