"""`./stator bench`: measurements beside those of other software, in the same run."""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from typing import TYPE_CHECKING

from stator.bench.benchmarks import BENCHMARKS
from stator.diagnostics import UserError

if TYPE_CHECKING:
    import argparse

    from stator.bench.figure import Figure


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "names",
        nargs="*",
        metavar="NAME",
        help=f"benchmarks to run: {', '.join(BENCHMARKS)} (default: all)",
    )
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def main(arguments: argparse.Namespace) -> int:
    unknown = [name for name in arguments.names if name not in BENCHMARKS]
    if unknown:
        raise UserError(
            f"error: unknown benchmark '{unknown[0]}'\nhint: known: {', '.join(BENCHMARKS)}"
        )
    figures: list[Figure] = []
    for name in arguments.names or BENCHMARKS:
        if not arguments.json:
            print(f"{name} ...", file=sys.stderr)
        figures += BENCHMARKS[name]()
    if arguments.json:
        print(json.dumps([asdict(figure) for figure in figures], indent=2))
    else:
        _show(figures)
    return 0


def _show(figures: list[Figure]) -> None:
    width = max(len(figure.what) for figure in figures)
    for figure in figures:
        verdict = "met" if figure.met else "NOT MET"
        value = f"{figure.value:10.4g} {figure.unit:<6}"
        print(f"{figure.what:<{width}}  {value} {figure.bound:<24} {verdict}")
    print("note: results vary on a shared machine; compare figures of the same run only")
