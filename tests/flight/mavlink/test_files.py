"""A ground station reads files and logs of a simulated flight, with pymavlink's own client of file
transfer."""

from __future__ import annotations

import json
import lzma
import struct
import subprocess
from typing import TYPE_CHECKING

from pymavlink import mavftp
from pymavlink.mavftp import FtpError
from tests.flight.mavlink.logs import LogReader
from tests.flight.mavlink.vehicle import COMMAND, Station, mavlink, met

from stator.emit.metadata import plain_crc

if TYPE_CHECKING:
    from pathlib import Path

LOG_PART = 46_080  # as MAVSDK asks for
NO_FOLDERS = ("/..", "/etc/../..", "/home")
NO_FILES = ("../../etc/passwd", "/etc/passwd", "/log/../general.json")


class Files:
    """A station that reads files."""

    def __init__(self, station: Station) -> None:
        self.client = mavftp.MAVFTP(station.link, 1, 1)

    def list(self, folder: str) -> dict[str, int | None]:
        """Sizes of files; None: a folder."""
        answer = self.client.cmd_list([folder])
        assert answer.error_code == FtpError.Success, folder
        return {e.name: None if e.is_dir else e.size_b for e in self.client.list_result}

    def get(self, path: str, local: Path) -> bytes:
        self.client.cmd_get([path, str(local)])
        answer = self.client.process_ftp_reply("OpenFileRO", timeout=60)
        assert answer.error_code == FtpError.Success, path
        return local.read_bytes()


def parameters_of(station: Station) -> dict[str, tuple[int, bytes]]:
    """MAVLink's type and bits of each."""
    station.link.mav.param_request_list_send(1, 1)
    values: dict[str, tuple[int, bytes]] = {}
    while True:
        value = station.wait("PARAM_VALUE", lambda v: v.param_index != 65535)
        values[value.param_id] = (value.param_type, bytes(value.get_msgbuf()[10:14]))
        if len(values) == value.param_count:
            return values


def unpacked(data: bytes) -> dict[str, tuple[int, bytes, bytes]]:
    """Of a param.pck: MAVLink's type, and bits of value and default."""
    types = {3: mavlink.MAV_PARAM_TYPE_INT32, 4: mavlink.MAV_PARAM_TYPE_REAL32}
    magic, entries, of_all = struct.unpack_from("<HHH", data)
    assert magic in (0x671B, 0x671C)
    assert entries == of_all
    at, name, found = 6, b"", {}
    while at < len(data):
        kind, lengths = data[at : at + 2]
        end = at + 3 + (lengths >> 4)
        name = name[: lengths & 15] + data[at + 2 : end]
        value = data[end : end + 4]
        has_default = bool(kind & 0x10)
        default = data[end + 4 : end + 8] if has_default else value
        at = end + (8 if has_default else 4)
        found[name.decode()] = (types[kind & 15], value, default)
    assert len(found) == entries
    return found


def check_tree(files: Files) -> None:
    assert files.list("/") == {"@PARAM": None, "etc": None, "log": None}
    assert set(files.list("/etc")) == {"general.json", "parameters.json.xz"}
    assert set(files.list("@PARAM")) == {"param.pck"}
    assert set(files.list("/log")) == {"0.ulg"}
    for folder in NO_FOLDERS:
        assert files.client.cmd_list([folder]).error_code == FtpError.FileNotFound, folder
    for file in NO_FILES:
        assert files.client.cmd_crc([file]).error_code == FtpError.FileNotFound, file


def check_metadata(station: Station, files: Files, folder: Path) -> None:
    """As QGroundControl follows them from the message on."""
    station.accept(mavlink.MAV_CMD_REQUEST_MESSAGE, 397)
    # COMPONENT_METADATA, which pymavlink's own messages lack.
    message = station.wait("UNKNOWN_397").get_msgbuf()
    _, file_crc, uri = struct.unpack("<II100s", bytes(message[10:-2]).ljust(108, b"\0"))
    general = files.get(uri.rstrip(b"\0").decode().removeprefix("mftp://"), folder / "general.json")
    assert plain_crc(general) == file_crc
    (entry,) = json.loads(general)["metadataTypes"]
    packed = files.get(entry["uri"].removeprefix("mftp://"), folder / "parameters.json.xz")
    assert plain_crc(packed) == entry["fileCrc"]
    described = {p["name"]: p for p in json.loads(lzma.decompress(packed))["parameters"]}
    values = parameters_of(station)
    assert list(described) == list(values)
    kinds = {"Float": mavlink.MAV_PARAM_TYPE_REAL32, "Int32": mavlink.MAV_PARAM_TYPE_INT32}
    for name, (kind, _) in values.items():
        assert kinds[described[name]["type"]] == kind, name
    height = described["MIS_TAKEOFF_ALT"]
    assert (height["shortDesc"], height["units"]) == ("navigator.takeoff_height", "m")
    assert height["min"] < height["default"] < height["max"]


def check_pack(station: Station, files: Files, folder: Path) -> None:
    """The same bits as one by one; a default where it differs."""
    station.link.mav.param_set_send(1, 1, b"MIS_TAKEOFF_ALT", 7.25, mavlink.MAV_PARAM_TYPE_REAL32)
    station.wait("PARAM_VALUE", lambda v: v.param_id == "MIS_TAKEOFF_ALT")
    values = parameters_of(station)
    name = "@PARAM/param.pck?withdefaults=1"
    pack = unpacked(files.get(name, folder / "param.pck"))
    assert {name: entry[:2] for name, entry in pack.items()} == values
    changed = {name for name, (_, value, default) in pack.items() if value != default}
    assert changed == {"MIS_TAKEOFF_ALT"}
    assert pack["MIS_TAKEOFF_ALT"][1] == struct.pack("<f", 7.25)
    answer = files.client.cmd_getparams([str(folder / "all.param"), str(folder / "defaults.param")])
    assert answer.error_code == FtpError.Success
    answer = files.client.process_ftp_reply("OpenFileRO", timeout=60)
    assert answer.error_code == FtpError.Success
    lines = (folder / "all.param").read_text().splitlines()
    assert len(lines) == len(values)


def check_nothing_is_written(files: Files, folder: Path) -> None:
    own = folder / "own.txt"
    own.write_text("mine")
    for path in ("/log/own.txt", "/etc/general.json"):
        assert files.client.cmd_put([str(own), path]).error_code == FtpError.Success  # it is begun
        assert files.client.process_ftp_reply("CreateFile").error_code == FtpError.FileProtected
        assert files.client.cmd_rm([path]).error_code == FtpError.FileProtected
    assert files.client.cmd_mkdir(["/new"]).error_code == FtpError.FileProtected


def test_files_and_logs_which_replay(tmp_path: Path) -> None:
    log = tmp_path / "files.ulg"
    with met(log) as (station, facts):
        files = Files(station)
        check_tree(files)
        check_metadata(station, files, tmp_path)
        check_pack(station, files, tmp_path)
        check_nothing_is_written(files, tmp_path)
        reader = LogReader(station)
        assert list(reader.entries()) == [0]
        part = reader.read(0, LOG_PART)
        head = files.client.read("/log/0.ulg", 1000, offset=500)
    assert facts["success"], facts["reason"]
    assert facts["refused_publications"] == 0
    written = log.read_bytes()
    assert part == written[:LOG_PART]
    assert head == written[500:1500]
    replayed = subprocess.run(
        [*COMMAND, "replay", str(log)], capture_output=True, text=True, check=False
    )
    assert replayed.returncode == 0, replayed.stdout + replayed.stderr
