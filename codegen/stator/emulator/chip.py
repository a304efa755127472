"""Runs the image of a Pixhawk on the emulated chip: the bytes that an upload writes."""

from __future__ import annotations

import json
import subprocess
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stator.build.px4_file import image_in
from stator.diagnostics import UserError
from stator.emulator.machine import MACHINE
from stator.emulator.qemu import SHIFT
from stator.processes import start

if TYPE_CHECKING:
    from collections.abc import Mapping

    from stator.emulator.qemu import Emulator

IMAGE_AT = 0x08004000  # the bootloader, which starts the image there, has the first 16 KB
WAIT_S = 10.0  # until the model listens


def run_image(
    emulator: Emulator,
    server: Path,
    px4: Path,
    seconds: float,
    lines: Mapping[str, Path] | None = None,
) -> dict[str, Any]:
    """Runs the image for emulated `seconds`. `server`: the program that is the model of the chip.
    `lines`: for serial lines by their name in the manual, the file for what they send. Returns what
    the model counted. Raises `UserError` with the rule of the chip that the firmware broke."""
    pipe = subprocess.PIPE
    with tempfile.TemporaryDirectory(prefix="stator-") as name:
        socket, image = Path(name) / "model", Path(name) / "image.bin"
        image.write_bytes(image_in(px4))
        words = [w for line, file in (lines or {}).items() for w in ("--line", line, str(file))]
        model = start([server, socket, f"{seconds:.9f}", *words], stdout=pipe, stderr=pipe)
        try:
            _await(socket, model)
            command = machine_command(emulator, socket, image)
            with start(command, stdout=pipe, stderr=subprocess.STDOUT) as machine:
                said = machine.communicate()[0]
            facts, errors = model.communicate(timeout=WAIT_S)
        finally:
            model.kill()
            model.wait()
    if machine.returncode != 0 or model.returncode != 0:
        raise UserError(f"{errors}{said}error: the emulated run ended early")
    found: dict[str, Any] = json.loads(facts)
    return found


def machine_command(emulator: Emulator, socket: Path, image: Path) -> list[str]:
    return [
        *(emulator.path, "-M", f"{MACHINE},model={socket},vectors={IMAGE_AT}"),
        *("-kernel", str(image), "-icount", f"shift={SHIFT},align=off,sleep=off"),
        *("-display", "none", "-monitor", "none", "-serial", "none", "-nic", "none"),
    ]


def _await(socket: Path, model: subprocess.Popen[str]) -> None:
    end_s = time.monotonic() + WAIT_S
    while not socket.exists() and model.poll() is None and time.monotonic() < end_s:
        time.sleep(0.01)
