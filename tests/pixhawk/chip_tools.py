"""What tests on the emulated chip of the Pixhawk need; they say what is missing."""

from __future__ import annotations

import pytest
from tests.emulation.firmware_tools import needs_toolchain

from stator.emulator.machine import chip_emulator
from stator.emulator.qemu import Emulator, NoEmulator


def needs_chip() -> Emulator:
    """Builds the emulator if that has not been done: some minutes."""
    needs_toolchain()
    try:
        return chip_emulator()
    except NoEmulator as missing:
        pytest.skip(f"NO PIXHAWK TESTED: {missing}")
