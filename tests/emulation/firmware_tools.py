"""What tests of firmware need besides the host's tools; they say what is missing."""

from __future__ import annotations

import shutil

import pytest

from stator.emulator.qemu import Emulator, NoEmulator, find_emulator


def needs_toolchain() -> None:
    if shutil.which("arm-none-eabi-g++") is None:
        pytest.skip("NO FIRMWARE TESTED: arm-none-eabi-g++ is missing; ./stator setup installs it")


def needs_emulator() -> Emulator:
    needs_toolchain()
    try:
        return find_emulator()
    except NoEmulator as missing:
        pytest.skip(f"NO FIRMWARE TESTED: {missing}")
