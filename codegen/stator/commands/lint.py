"""`./stator lint`: format and static checks. The tests run each of them as well."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stator import HOME
from stator.diagnostics import in_place
from stator.testing.lint import CHECKS, output

if TYPE_CHECKING:
    import argparse


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--fix", action="store_true", help="first repair what the tools can repair")
    parser.add_argument("--long", action="store_true", help="run clang-tidy as well")


def main(options: argparse.Namespace) -> int:
    failed = False
    for name, check in CHECKS.items():
        if check.long and not options.long:
            continue
        if options.fix and check.fixer:
            output(check.fixer(HOME), HOME)
        problems = check.run(HOME)
        failed |= bool(problems)
        print(f"{name}: {'failed' if problems else 'ok'}", flush=True)
        if problems:
            print(problems)
            fix = in_place("hint: ./stator lint --fix")
            print(fix if check.fixer else "hint: repair this by hand")
    return 1 if failed else 0
