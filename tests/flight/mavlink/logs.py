"""A station that downloads a log, and asks for what is missing."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tests.flight.mavlink.vehicle import HANGS_S

if TYPE_CHECKING:
    from tests.flight.mavlink.vehicle import Station

AGAIN_S = 0.3  # until it asks again
IN_MESSAGE = 90


class LogReader:
    def __init__(self, station: Station) -> None:
        self.station = station

    def _heard(self, kind: str) -> Any:
        return self.station.link.recv_match(type=kind, blocking=True, timeout=AGAIN_S)

    def entries(self) -> dict[int, Any]:
        """By number: what the vehicle lists."""
        found: dict[int, Any] = {}
        until = self.station.clock.time() + HANGS_S
        while self.station.clock.time() < until:
            self.station.link.mav.log_request_list_send(1, 1, 0, 0xFFFF)
            while entry := self._heard("LOG_ENTRY"):
                if entry.num_logs == 0:
                    return {}
                found[entry.id] = entry
                if len(found) == entry.num_logs:
                    return found
        raise AssertionError("no LOG_ENTRY")

    def read(self, number: int, count: int) -> bytes:
        """Its first bytes."""
        parts: dict[int, bytes] = {}
        until = self.station.clock.time() + HANGS_S
        begin = 0
        while begin < count:
            assert self.station.clock.time() < until, f"{begin} of {count} bytes"
            self.station.link.mav.log_request_data_send(1, 1, number, begin, count - begin)
            while data := self._heard("LOG_DATA"):
                if data.id == number:
                    parts[data.ofs] = bytes(data.data[: data.count])
                if data.count < IN_MESSAGE or data.ofs + data.count >= count:
                    break
            while parts.get(begin):
                begin += len(parts[begin])
        self.station.link.mav.log_request_end_send(1, 1)
        return b"".join(parts[at] for at in sorted(parts))[:count]
