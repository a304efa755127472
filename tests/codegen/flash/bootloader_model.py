"""A model of the board's side of the PX4 bootloader protocol, revision 5, on a pseudo-terminal: it
keeps flash bytes and answers as the protocol says. It stands for no hardware."""

from __future__ import annotations

import os
import struct
import threading
import tty
import zlib
from dataclasses import dataclass, field

INSYNC_OK = b"\x12\x10"


@dataclass
class BootloaderModel:
    board_id: int = 9
    revision: int = 5
    flash_bytes: int = 2080768
    corrupts: bool = False  # a bit of the flash does not take its value
    silent_after: int = 1_000_000  # chunks until it answers no more
    flash: bytearray = field(default_factory=bytearray)
    erased: bool = False
    started: bool = False
    chunks: int = 0

    def __post_init__(self) -> None:
        self._host, self._board = os.openpty()
        tty.setraw(self._host)
        tty.setraw(self._board)
        self.port = os.ttyname(self._board)
        self.thread = threading.Thread(target=self._serve, daemon=True)
        self.thread.start()

    def _read(self, count: int) -> bytes:
        data = b""
        while len(data) < count:
            data += os.read(self._host, count - len(data))
        return data

    def _answer(self, data: bytes = b"") -> None:
        if self.chunks < self.silent_after:
            os.write(self._host, data + INSYNC_OK)

    def _serve(self) -> None:
        while not self.started:
            command = self._read(1)
            if command == b"\x21":
                self._read(1)
                self._answer()
            elif command == b"\x22":
                what = self._read(2)[0]
                facts = {1: self.revision, 2: self.board_id, 3: 0, 4: self.flash_bytes}
                self._answer(struct.pack("<I", facts[what]))
            elif command == b"\x23":
                self._read(1)
                self.flash, self.erased = bytearray(), True
                self._answer()
            elif command == b"\x27":
                self._program()
            elif command == b"\x29":
                self._read(1)
                self._answer(struct.pack("<I", self._crc()))
            elif command == b"\x30":
                self._read(1)
                self.started = True

    def _program(self) -> None:
        chunk = self._read(self._read(1)[0])
        assert self._read(1) == b"\x20"
        assert self.erased
        assert len(chunk) % 4 == 0
        self.flash += chunk
        self.chunks += 1
        if self.corrupts:
            self.flash[0] ^= 1
            self.corrupts = False
        self._answer()

    def _crc(self) -> int:
        # As the bootloader's table does it: starts with 0, no inversion at the end.
        image = bytes(self.flash) + b"\xff" * (self.flash_bytes - len(self.flash))
        return zlib.crc32(image, 0xFFFFFFFF) ^ 0xFFFFFFFF
