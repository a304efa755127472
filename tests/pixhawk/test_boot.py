"""The image that is flashed to a Pixhawk starts on the emulated chip: reset, clock tree, pins,
timers, watchdog, serial lines, by the strict model of the chip's registers."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import pytest
from pymavlink.dialects.v20 import common
from tests.pixhawk.chip_tools import needs_chip

from stator import HOME
from stator.build.cmake import build_pixhawk
from stator.build.image import build_image, image_files
from stator.build.px4_file import image_in
from stator.diagnostics import UserError
from stator.emulator.chip import run_image
from stator.pipeline import make_plan

if TYPE_CHECKING:
    from pathlib import Path

    from stator.emulator.qemu import Emulator

SECONDS = 5.0


@pytest.fixture(scope="module")
def emulator() -> Emulator:
    return needs_chip()


@pytest.fixture(scope="module")
def image() -> bytes:
    """What an upload of the `.px4` file writes."""
    graph = HOME / "graph" / "quad_outdoor.yaml"
    files = image_files(make_plan(str(graph), "fmu_v2"), build_image(graph, "fmu_v2"))
    return image_in(files["px4"])


def test_the_flashed_image_starts_and_sends_heartbeats(
    emulator: Emulator, image: bytes, tmp_path: Path
) -> None:
    line = tmp_path / "telem1"
    facts = run_image(emulator, build_pixhawk(), image, SECONDS, {"USART2": line})
    assert facts["simulated_s"] == SECONDS
    assert facts["core_clock_hz"] == 168_000_000
    assert facts["resets"] == 0  # the watchdog was kicked
    # The MPU6000 was started within 0.3 s, by its driver, and read at each ready line since then.
    assert facts["imu_read"] >= (SECONDS - 0.3) * 1000
    assert facts["missed_samples"] == 0
    reader = common.MAVLink(None)
    messages = reader.parse_buffer(line.read_bytes()) or []
    kinds = Counter(message.get_type() for message in messages)
    assert kinds["HEARTBEAT"] == SECONDS
    assert kinds["BAD_DATA"] == 0


def test_an_image_that_breaks_a_rule_of_the_chip_is_stopped(
    emulator: Emulator, image: bytes
) -> None:
    """One that begins with a write to a peripheral whose clock is off."""
    code = bytearray(image)
    entry = (int.from_bytes(code[4:8], "little") & ~1) - 0x08004000
    # ldr r0, [pc, #4]; str r0, [r0]; b .; the address of GPIOA
    code[entry : entry + 12] = bytes.fromhex("0148 0060 fee7 00bf 00000240")
    with pytest.raises(UserError, match=r"GPIOA: written while its clock is off(.|\n)*pc 0x080"):
        run_image(emulator, build_pixhawk(), bytes(code), 1.0)
