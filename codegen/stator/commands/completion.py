"""`./stator completion`: prints the completion of the command line for a shell.

It comes from the parsers of all commands, so it has nothing to keep up to date.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import shtab

from stator import HOME
from stator.arguments import path

SHELLS = ("bash", "zsh", "fish")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "shell", choices=SHELLS, help='for bash: eval "$(./stator completion bash)"'
    )


def main(arguments: argparse.Namespace) -> int:
    parser: argparse.ArgumentParser = arguments.parser
    _add_candidates(parser)
    print(shtab.complete(parser, shell=arguments.shell))
    return 0


def _add_candidates(parser: argparse.ArgumentParser) -> None:
    """What argparse does not know: names of boards, and values that are files."""
    for action in parser._actions:  # shtab reads the same list
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                _add_candidates(command)
        elif action.dest == "board":
            action.choices = sorted(file.parent.name for file in HOME.glob("boards/*/board.yaml"))
        elif action.dest == "graph" or action.type in (path, Path):
            action.complete = shtab.FILE  # type: ignore[attr-defined]
