"""Programs of the C++ tests that a Python test runs."""

import subprocess
from pathlib import Path

from stator import HOME

FOLDER = HOME / "build" / "host"


def host_program(path: str) -> Path:
    """Builds the program; its path is below the build folder. `./stator test` has configured it."""
    program = FOLDER / path
    command = ["cmake", "--build", str(FOLDER), "--target", program.name]
    finished = subprocess.run(command, check=False, capture_output=True, text=True)
    assert finished.returncode == 0, finished.stdout[-2000:] + finished.stderr
    return program
