"""Talks to the PX4 bootloader over a serial line: identify, erase, program, check, start.

Protocol revision 3 to 5: a command and its arguments end in EOC. The answer is the requested data,
then INSYNC and a status. The check is a CRC-32 of the whole flash of the application, with initial
value 0 and without the final inversion."""

from __future__ import annotations

import struct
import zlib
from typing import TYPE_CHECKING, Protocol

from stator.diagnostics import UserError

if TYPE_CHECKING:
    from collections.abc import Callable

EOC, INSYNC, OK = b"\x20", b"\x12", b"\x10"
STATUS = {b"\x11": "failed", b"\x13": "invalid command", b"\x14": "this chip revision is refused"}
GET_SYNC, GET_DEVICE, CHIP_ERASE = b"\x21", b"\x22", b"\x23"
PROG_MULTI, GET_CRC, REBOOT = b"\x27", b"\x29", b"\x30"
REVISION, BOARD_ID, FLASH_SIZE = b"\x01", b"\x02", b"\x04"
REVISIONS = range(3, 6)
CHUNK = 252  # bytes of a PROG_MULTI; whole words, below 255
ERASE_S = 30.0  # 2 MB take up to 24 s
CRC_S = 5.0


class Port(Protocol):
    """The part of serial.Serial that is used here."""

    timeout: float | None

    def read(self, size: int = 1) -> bytes: ...
    def write(self, data: bytes) -> int | None: ...
    def reset_input_buffer(self) -> None: ...


def crc_of_flash(image: bytes, flash_bytes: int) -> int:
    state = zlib.crc32(image, 0xFFFFFFFF)
    return zlib.crc32(b"\xff" * (flash_bytes - len(image)), state) ^ 0xFFFFFFFF


class Bootloader:
    """Raises `UserError` for a wrong or a missing answer."""

    def __init__(self, port: Port) -> None:
        self._port = port
        self.flash_bytes = 0

    def is_there(self) -> bool:
        self._port.reset_input_buffer()
        self._port.write(GET_SYNC + EOC)
        return self._port.read(2) == INSYNC + OK

    def identify(self, board_id: int, image_bytes: int) -> None:
        """Checks that this is the right board, and that the image fits."""
        revision = self._get(REVISION)
        if revision not in REVISIONS:
            raise UserError(
                f"error: expected bootloader protocol revision {REVISIONS.start} to "
                f"{REVISIONS.stop - 1}, found {revision}\nhint: update the board's bootloader"
            )
        found = self._get(BOARD_ID)
        if found != board_id:
            raise UserError(
                f"error: expected a board with id {board_id} on this port, found id {found}; "
                "nothing was erased\nhint: use --port for another port"
            )
        self.flash_bytes = self._get(FLASH_SIZE)
        if image_bytes > self.flash_bytes:
            raise UserError(
                f"error: expected an image of at most {self.flash_bytes} bytes, found "
                f"{image_bytes}; nothing was erased\n"
                "hint: make the graph smaller; ./stator build shows its parts"
            )

    def erase(self) -> None:
        self._port.write(CHIP_ERASE + EOC)
        self._expect_ok("erase", ERASE_S)

    def program(self, image: bytes, progress: Callable[[int], None]) -> None:
        for start in range(0, len(image), CHUNK):
            chunk = image[start : start + CHUNK]
            self._port.write(PROG_MULTI + bytes([len(chunk)]) + chunk + EOC)
            self._expect_ok(f"program at byte {start}")
            progress(start + len(chunk))

    def verify(self, image: bytes) -> None:
        self._port.write(GET_CRC + EOC)
        found = self._number("check", CRC_S)
        expected = crc_of_flash(image, self.flash_bytes)
        if found != expected:
            raise UserError(
                f"error: expected CRC {expected:08x} of the flash, found {found:08x}\n"
                "hint: repeat the command; the board does not start a wrong image"
            )

    def start(self) -> None:
        self._port.write(REBOOT + EOC)

    def _get(self, what: bytes) -> int:
        self._port.write(GET_DEVICE + what + EOC)
        return self._number("identify")

    def _number(self, step: str, timeout_s: float | None = None) -> int:
        answer = self._read(4, step, timeout_s)
        self._expect_ok(step)
        number: int = struct.unpack("<I", answer)[0]
        return number

    def _expect_ok(self, step: str, timeout_s: float | None = None) -> None:
        answer = self._read(2, step, timeout_s)
        if answer != INSYNC + OK:
            said = STATUS.get(answer[1:], answer.hex()) if answer[:1] == INSYNC else answer.hex()
            raise UserError(f"error: the bootloader refused to {step}: {said}\n{AGAIN}")

    def _read(self, count: int, step: str, timeout_s: float | None) -> bytes:
        usual = self._port.timeout
        self._port.timeout = timeout_s or usual
        try:
            answer = self._port.read(count)
        finally:
            self._port.timeout = usual
        if len(answer) != count:
            raise UserError(f"error: no answer from the bootloader to: {step}\n{AGAIN}")
        return answer


AGAIN = (
    "hint: unplug the board, plug it in again, and repeat the command; the bootloader is unchanged"
)
