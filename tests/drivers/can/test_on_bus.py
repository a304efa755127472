"""The drivers and nodes of CAN on a bus of a real kernel: on_bus.py, inside tests/with-can."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from stator.build import build
from stator.library import HOME

HERE = Path(__file__).parent
WITH_CAN = HOME / "tests" / "with-can"
CANNOT = 125  # with-can's status if it cannot make a bus


@pytest.fixture(scope="module")
def link() -> Path:
    return build(HERE / "graphs" / "link.yaml", "linux", executor="pthread")


def on_bus(
    seconds: int, *command: str | Path, **variables: str
) -> subprocess.CompletedProcess[str]:
    words = [str(WITH_CAN), "-t", str(seconds), "--", *(str(word) for word in command)]
    finished = subprocess.run(
        words, capture_output=True, text=True, check=False, env=dict(os.environ) | variables
    )
    if finished.returncode == CANNOT:
        pytest.skip(f"no CAN bus here: {finished.stderr.strip()}")
    return finished


def test_on_the_bus(link: Path) -> None:
    pytest_ = [sys.executable, "-I", "-X", "utf8", "-m", "pytest", "-q", "--no-header"]
    options = ["-p", "no:cacheprovider", "-o", "addopts=--import-mode=importlib"]
    finished = on_bus(600, *pytest_, *options, HERE / "on_bus.py", STATOR_LINK=str(link))
    print(finished.stdout)
    assert finished.returncode == 0, finished.stdout[-6000:] + finished.stderr[-2000:]
