"""A ground station talks to the firmware through its serial port, and so does ./stator param."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from pymavlink import mavparm
from pyulog import ULog
from tests.emulation.firmware_tools import needs_emulator
from tests.flight.mavlink.vehicle import OUTDOOR, Station, flying, free_port, mavlink

from stator import __main__ as cli
from stator.build.cmake import RECORDING, build_plant
from stator.build.image import build_image

if TYPE_CHECKING:
    from pathlib import Path

    import pytest

TAKE_OFF = "MIS_TAKEOFF_ALT"


def ask(capsys: pytest.CaptureFixture[str], *words: str) -> Any:
    capsys.readouterr()
    assert cli.main(["param", *words, "--json"]) == 0, capsys.readouterr().err
    return json.loads(capsys.readouterr().out)


def read(station: Station, name: str) -> float:
    station.link.mav.param_request_read_send(1, 1, name.encode(), -1)
    value: float = station.wait("PARAM_VALUE", lambda value: value.param_id == name).param_value
    return value


def test_parameters_of_the_firmware(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Listed and set by a station, set by ./stator param, and there again after a restart."""
    needs_emulator()
    build_image(OUTDOOR, "qemu_f405", RECORDING)  # what takes minutes, before a station waits
    build_plant()
    link, log = tmp_path / "link", tmp_path / "first.ulg"
    port = free_port()
    options = ["--mavlink", f"udp:{port}", "--nonvolatile", str(tmp_path / "kept.records")]
    with flying(log, *options, "--link", str(link), how="emulate") as facts:
        station = Station(f"udpin:127.0.0.1:{port}")
        station.connect()
        station.link.param_fetch_all()
        ids: dict[int, str] = {}
        count = 1
        while len(ids) < count:
            value = station.wait("PARAM_VALUE")
            count = value.param_count
            ids[value.param_index] = value.param_id
        assert sorted(ids) == list(range(count))

        setter = mavparm.MAVParmDict()
        assert setter.mavset(station.link, TAKE_OFF, 9.0, retries=600, parm_type=9)
        station.link.mav.param_set_send(1, 1, TAKE_OFF.encode(), 1e9, 9)
        refused = station.wait("PARAM_ERROR")
        assert refused.error == mavlink.MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE

        own = {
            row["id"]: row["value"] for row in ask(capsys, "list", "--link", str(link))["params"]
        }
        assert sorted(own) == [ids[i] for i in range(count)]
        assert own[TAKE_OFF] == 9.0
        (change,) = ask(capsys, "set", "RTL_RETURN_ALT", "44", "--link", str(link))["changes"]
        assert change["result"] == "written"
        assert read(station, "RTL_RETURN_ALT") == 44.0
        station.close()
    assert facts["reason"].startswith("ran to its end"), facts
    assert (facts["lost_samples"], facts["missed_samples"]) == (0, 0)
    line = ULog(str(log)).get_dataset("telem1_status").data
    assert line["bytes_per_s"][0] == 57600 // 10
    assert (line["rx_lost"][-1], line["tx_lost"][-1]) == (0, 0)

    port = free_port()
    options[1] = f"udp:{port}"
    with flying(tmp_path / "second.ulg", *options, how="emulate"):
        station = Station(f"udpin:127.0.0.1:{port}")
        station.connect()
        assert (read(station, TAKE_OFF), read(station, "RTL_RETURN_ALT")) == (9.0, 44.0)
        station.close()
