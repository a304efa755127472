"""A ground station uploads plans, reads them back, and has the mission flown."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pyulog import ULog
from tests.flight.mavlink.vehicle import NAN, mavlink, met

if TYPE_CHECKING:
    from pathlib import Path

    from tests.flight.mavlink.vehicle import Item, Station

RELATIVE = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT


def square(station: Station) -> list[Item]:
    places = [station.place(*at) for at in ((12.0, 0.0), (12.0, 12.0), (0.0, 12.0))]
    items: list[Item] = [(RELATIVE, 22, 0.0, 0.0, 0.0, NAN, *station.place(0.0, 0.0), 6.0)]
    for place in places:
        items.append((RELATIVE, 16, 0.0, 2.0, 0.0, NAN, *place, 6.0))
        # Some stations write the speed behind each place.
        items.append((mavlink.MAV_FRAME_MISSION, 178, 1.0, 4.0, -1.0, 0.0, 0, 0, NAN))
    return [*items, (mavlink.MAV_FRAME_MISSION, 20, 0.0, 0.0, 0.0, 0.0, 0, 0, 0.0)]


def test_plans_go_there_and_back_and_a_mission_is_flown(tmp_path: Path) -> None:
    log = tmp_path / "mission.ulg"
    with met(log) as (station, facts):
        corners = [station.place(*at) for at in ((-90.0, -90.0), (90.0, -90.0), (90.0, 90.0))]
        fence: list[Item] = [(0, 5001, 3.0, 0.0, 0.0, 0.0, *corner, 0.0) for corner in corners]
        assert station.upload(fence, 1).type == mavlink.MAV_MISSION_ACCEPTED
        assert [(item.x, item.y) for item in station.download(1)] == corners
        station.link.mav.mission_clear_all_send(1, 1, 1)
        assert station.wait("MISSION_ACK").type == mavlink.MAV_MISSION_ACCEPTED
        assert station.download(1) == []

        items = square(station)
        assert station.upload(items).type == mavlink.MAV_MISSION_ACCEPTED
        back = station.download()
        assert [(i.frame, i.command, i.x, i.y) for i in back] == [
            (item[0], item[1], item[6], item[7]) for item in items
        ]
        station.accept(mavlink.MAV_CMD_DO_SET_MISSION_CURRENT, 3)
        station.wait("MISSION_CURRENT", lambda current: current.seq == 3)
        station.link.mav.mission_set_current_send(1, 1, 0)
        station.wait("MISSION_CURRENT", lambda current: current.seq == 0)

        station.accept(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1)
        station.accept(mavlink.MAV_CMD_MISSION_START)
        station.wait_mode("MISSION")
        for place in (1, 3, 5):
            station.wait("MISSION_ITEM_REACHED", lambda reached, place=place: reached.seq == place)
            if place != 1:
                continue
            station.accept(mavlink.MAV_CMD_DO_SET_MODE, 1, 4, 3)
            station.wait_mode("LOITER")
            station.accept(mavlink.MAV_CMD_DO_SET_MODE, 1, 4, 4)
            station.wait_mode("MISSION")
        station.wait_mode("RTL")
        station.wait_armed(False)
    assert facts["success"], facts["reason"]
    assert facts["refused_publications"] == 0
    result = next(d.data for d in ULog(str(log)).data_list if d.name == "mission_result")
    assert max(result["seq_reached"]) >= 5


def test_a_hundred_items(tmp_path: Path) -> None:
    """As many as a vehicle keeps go there and back through the mission's file."""
    with met(tmp_path / "items.ulg") as (station, facts):
        items: list[Item] = [
            (RELATIVE, 16, 0.0, 2.0, 0.0, NAN, *station.place(0.5 * i, 1.0), 6.0)
            for i in range(100)
        ]
        assert station.upload(items).type == mavlink.MAV_MISSION_ACCEPTED
        back = station.download()
        assert [(item.x, item.y) for item in back] == [(item[6], item[7]) for item in items]
    assert facts["success"], facts["reason"]
