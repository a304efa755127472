"""Plans of small graphs, which tests write as text."""

from __future__ import annotations

import shutil
from pathlib import Path
from textwrap import dedent

from stator.graph.check import check
from stator.plan.plan import Plan, plan
from stator.prove.proof import Proof, prove

PARTS = Path(__file__).with_name("parts")


def written(folder: Path, text: str, name: str = "small") -> Path:
    """The file of a graph on the board `bench`, with its parts beside it."""
    shutil.copytree(PARTS, folder, dirs_exist_ok=True)
    graph = folder / f"{name}.yaml"
    graph.write_text("board: bench\n" + dedent(text), encoding="utf-8")
    return graph


def planned(folder: Path, text: str) -> Plan:
    return plan(*check(written(folder, text)))


def proved(folder: Path, text: str) -> Proof:
    return prove(planned(folder, text))
