"""`./stator test`: builds, runs the C++ and the Python tests, and counts them together."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stator.testing.junit import Outcome
from stator.testing.project import project_of, run_project
from stator.testing.run import SLOWEST, closing_lines, run_all, slowest_lines

if TYPE_CHECKING:
    import argparse


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--long", action="store_true", help="run the long tests as well")
    parser.add_argument(
        "names",
        nargs="*",
        metavar="NAME",
        help="file or folder of tests, or part of a test's name (as for ctest -R and pytest -k)",
    )


def main(options: argparse.Namespace) -> int:
    project = project_of(options.names)
    if project is None:
        cases = run_all(options.names, options.long)
    else:
        cases = run_project(project, options.names, options.long)
    if not any(case.outcome is not Outcome.SKIPPED for case in cases):
        matches = f": no test matches {' '.join(options.names)}" if options.names else ""
        longer = "" if options.long else "\nhint: add --long to include the long tests"
        print(f"no test ran{matches}{longer}")
    if project is None and not options.names:
        print("\n".join(["", f"slowest {SLOWEST}:", *slowest_lines(cases)]))
    print("\n".join(["", *closing_lines(cases)]), flush=True)
    failed = any(case.outcome is Outcome.FAILED for case in cases)
    passed = any(case.outcome is Outcome.PASSED for case in cases)
    return 1 if failed or not passed else 0
