"""`./stator flash` against a model of the bootloader, and the .px4 file of ground stations."""

from __future__ import annotations

import base64
import json
import zlib
from pathlib import Path

import pytest
from tests.codegen.flash.bootloader_model import BootloaderModel
from tests.emulation.firmware_tools import needs_toolchain

from stator import HOME
from stator import __main__ as cli
from stator.build.cmake import short_name
from stator.build.px4_bootloader import crc_of_flash
from stator.commands import flash

# Nodes without devices, so that nothing waits for a driver.
GRAPH = HOME / "graph" / "examples" / "chain.yaml"


def run(*arguments: str) -> int:
    needs_toolchain()
    return cli.main(["flash", str(GRAPH), "--board", "fmu_v2", "--unproven", *arguments])


def test_the_crc_is_that_of_a_bitwise_division() -> None:
    """The reflected polynomial of IEEE 802.3, bit by bit, beginning with 0."""
    state = 0
    for byte in b"stator" + b"\xff" * 10:
        state ^= byte
        for _ in range(8):
            state = state >> 1 ^ (0xEDB88320 if state & 1 else 0)
    assert crc_of_flash(b"stator", 16) == state


def test_the_whole_image_is_programmed_checked_and_started(
    capsys: pytest.CaptureFixture[str],
) -> None:
    board = BootloaderModel()
    assert run("--port", board.port) == 0
    folder = HOME / "build" / f"{short_name(GRAPH)}-fmu_v2"
    image = (folder / "graph_program.bin").read_bytes()
    assert bytes(board.flash[: len(image)]) == image
    board.thread.join(10.0)
    assert board.started
    assert "check     passed" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("board", "message", "erased"),
    [
        (
            BootloaderModel(board_id=50),
            "expected a board with id 9 on this port, found id 50",
            False,
        ),
        (BootloaderModel(revision=2), "protocol revision 3 to 5, found 2", False),
        (BootloaderModel(flash_bytes=1024), "an image of at most 1024 bytes", False),
        (BootloaderModel(corrupts=True), "of the flash, found", True),
        (
            BootloaderModel(silent_after=3),
            "no answer from the bootloader to: program at byte 504",
            True,
        ),
    ],
)
def test_what_goes_wrong_is_said_and_nothing_starts(
    board: BootloaderModel, message: str, erased: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("--port", board.port) == 2
    assert message in capsys.readouterr().err
    assert board.erased == erased
    assert not board.started


def test_no_bootloader(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr(flash, "WAIT_S", 0.2)
    assert run("--port", str(tmp_path / "tty")) == 2
    assert "no answer from a bootloader" in capsys.readouterr().err


def test_a_dry_run_shows_the_steps_and_touches_no_port(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert run("--dry-run", "--port", str(tmp_path / "tty")) == 0
    steps = [line.split()[0] for line in capsys.readouterr().out.splitlines()]
    assert steps == ["built", "wait", "identify", "erase", "program", "check", "start"]


@pytest.mark.parametrize(
    ("method", "command"),
    [
        ("dfu", "dfu-util --alt 0 --dfuse-address 0x08004000:leave --download "),
        ("probe", "pyocd flash --target stm32f427vi --base-address 0x08004000 "),
    ],
)
def test_a_dry_run_shows_the_command_of_other_tools(
    method: str, command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("--dry-run", "--method", method) == 0
    assert f"run       {command}" in capsys.readouterr().out


def test_a_graph_whose_devices_have_no_driver_is_refused(
    capsys: pytest.CaptureFixture[str],
) -> None:
    needs_toolchain()
    graph = HOME / "graph" / "quad_outdoor.yaml"
    assert cli.main(["flash", str(graph), "--board", "fmu_v2", "--unproven"]) == 2
    expected = "error: cannot flash this image: board fmu_v2 has no driver for mag0, "
    assert expected in capsys.readouterr().err


def test_a_graph_without_a_logger_cannot_record(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("--record", "--dry-run") == 2
    assert "error: --record: missing node of app 'logger' in " in capsys.readouterr().err


def test_what_is_not_proven_is_refused_before_anything_is_built(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The example has no budgets: the command that measures them is named."""
    assert cli.main(["flash", str(GRAPH), "--board", "fmu_v2"]) == 2
    error = capsys.readouterr().err
    assert "missing budget of" in error
    assert "hint: measure: ./stator measure graph/examples/chain.yaml --board fmu_v2\n" in error
    assert "error: the deadlines of chain on fmu_v2 are not proven\n" in error


def test_a_board_that_is_nothing_to_flash(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["flash", str(HOME / "graph" / "quad.yaml"), "--board", "sitl"]) == 2
    assert "its board.yaml has no key `upload`" in capsys.readouterr().err


def test_the_px4_file_holds_the_image_and_its_board() -> None:
    needs_toolchain()
    quad = str(HOME / "graph" / "quad.yaml")
    assert cli.main(["build", quad, "--board", "fmu_v2"]) == 0
    folder = HOME / "build" / "quad-fmu_v2"
    fields = json.loads((folder / "quad.px4").read_text())
    image = zlib.decompress(base64.b64decode(fields["image"]))
    flashed = (folder / "graph_program.bin").read_bytes()
    assert image[: len(flashed)] == flashed
    assert len(image) == fields["image_size"]
    assert fields["image_size"] % 4 == 0
    assert fields["description"] == "Stator, graph quad"
    # The Pixhawk's id, and its 2 MB of flash less the bootloader's 16 KB.
    assert (fields["board_id"], fields["image_maxsize"]) == (9, 2 * 1024 * 1024 - 16 * 1024)
    # The stack pointer and the reset handler of the first two vectors: what the bootloader checks.
    stack, reset = (int.from_bytes(image[i : i + 4], "little") for i in (0, 4))
    assert stack == 0x10010000
    assert 0x08004000 < reset < 0x08004000 + len(image)
