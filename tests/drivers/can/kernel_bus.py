"""Runs a command where there is a CAN bus of a real kernel."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from stator import HOME

if TYPE_CHECKING:
    from collections.abc import Sequence

WITH_CAN = HOME / "tests" / "with-can"
CANNOT = 125  # with-can's status if it cannot make a bus


def on_bus(
    seconds: int, *command: str | Path, options: Sequence[str] = (), **variables: str
) -> subprocess.CompletedProcess[str]:
    words = [WITH_CAN, "-t", str(seconds), *options, "--", *command]
    finished = subprocess.run(
        words,
        capture_output=True,
        text=True,
        check=False,
        cwd=HOME,
        env=dict(os.environ) | variables,
    )
    if finished.returncode == CANNOT:
        pytest.skip(f"no CAN bus here: {finished.stderr.strip()}")
    return finished
