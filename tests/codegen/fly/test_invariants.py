"""The invariants of every flight, on flights that break one of them by construction."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stator.flight.invariants import Broken, Setting, first_broken

TAKE_OFF_S, UP_S, DOWN_S, LANDED_S, DISARMED_S, END_S = 5.0, 10.0, 40.0, 50.0, 52.0, 54.0
TERMINATION, HOLD, MISSION, RETURN, POSITION, LAND = 13, 4, 3, 5, 2, 18
SETTING = Setting(
    needs={MISSION: frozenset({"height", "position"}), LAND: frozenset({"height", "position"})},
    fence_radius=50.0,
    fence_height=30.0,
    origin=(47.0, 8.0),
)
ANY = Setting(origin=(47.0, 8.0))


class Flown:
    """A good flight: straight up 10 m, and down again. Tests spoil a part of it."""

    def __init__(self) -> None:
        self.t = np.arange(0.0, END_S, 0.01)
        self.north = np.zeros_like(self.t)
        self.up = np.interp(self.t, [TAKE_OFF_S, UP_S, DOWN_S, LANDED_S], [0.0, 10.0, 10.0, 0.0])
        self.roll = np.zeros_like(self.t)
        self.mode = np.where(self.t < DOWN_S, MISSION, LAND)
        self.armed = (self.t >= 3.0) & (self.t < DISARMED_S)
        self.turning = self.armed.copy()
        self.rotor = np.full_like(self.t, 500.0)
        self.failsafe = np.zeros_like(self.t)
        self.throttle = np.zeros_like(self.t)
        self.valid = np.ones_like(self.t)
        self.off_m = np.zeros_like(self.t)  # of the estimate, downwards
        self.ended = "motors_stopped"

    def truth(self) -> dict[str, Any]:
        zero, one = np.zeros_like(self.t), np.ones_like(self.t)
        return {
            "time_us": self.t * 1e6,
            **{"position_n": self.north, "position_e": zero, "position_d": -self.up},
            **{"velocity_n": np.gradient(self.north, self.t), "velocity_e": zero},
            "velocity_d": -np.gradient(self.up, self.t),
            **{"q_w": np.cos(self.roll / 2), "q_x": np.sin(self.roll / 2), "q_y": zero},
            **{"rotor_1": self.rotor, "rotor_2": zero},
            **{"q_z": zero, "on_ground": (self.up < 0.01) * one, "wind_n": zero, "wind_e": zero},
        }

    def log(self) -> Any:
        nan = np.full_like(self.t, np.nan)
        one = np.ones_like(self.t)
        control = np.where(self.turning, 0.5, np.nan)
        topics = {
            "vehicle_status": {
                "nav_state": self.mode,
                "arming_state": np.where(self.armed, 2, 1),
                "failsafe": self.failsafe,
            },
            "actuator_motors": {f"control[{i}]": control if i < 4 else nan for i in range(12)},
            "manual_control_setpoint": {"throttle": self.throttle},
            "vehicle_local_position": {
                **{"x": self.north, "y": 0 * one, "z": -self.up + self.off_m},
                **{"vx": np.gradient(self.north, self.t), "vy": 0 * one},
                **{"vz": -np.gradient(self.up, self.t), "heading": 0 * one},
                **{"eph": 0.5 * one, "epv": 0.5 * one, "evh": 0.2 * one, "evv": 0.2 * one},
                **{"xy_valid": self.valid, "v_xy_valid": self.valid},
                **{"z_valid": self.valid, "v_z_valid": self.valid},
                **{"heading_good_for_control": one, "xy_global": one},
                **{"ref_lat": 47.0 * one, "ref_lon": 8.0 * one},
            },
        }
        return SimpleNamespace(
            data_list=[
                SimpleNamespace(name=name, multi_id=0, data={"timestamp": self.t * 1e6, **data})
                for name, data in topics.items()
            ]
        )

    def broken(self, setting: Setting = SETTING) -> Broken | None:
        return first_broken(self.log(), self.truth(), self.ended, setting)

    def name(self, setting: Setting = SETTING) -> str:
        broken = self.broken(setting)
        return "" if broken is None else broken.name


def test_a_good_flight_breaks_none() -> None:
    assert Flown().broken() is None


def test_motors_that_stop_in_the_air() -> None:
    flown = Flown()
    flown.turning &= flown.t < 45.0  # 5 m up
    broken = flown.broken()
    assert broken is not None
    assert broken.name == "motors_stopped_in_the_air"
    assert broken.as_json()["time_s"] == pytest.approx(45.0, abs=0.011)
    assert broken.as_json()["position_m"] == pytest.approx([0.0, 0.0, -5.0], abs=0.02)
    flown.mode[flown.t >= 45.0] = TERMINATION
    assert flown.name() == ""


def test_motors_that_stop_near_the_ground() -> None:
    flown = Flown()
    flown.turning &= flown.t < 49.6  # 0.4 m up
    assert flown.name() == ""


@pytest.mark.parametrize(("roll_deg", "how"), [(175.0, "upside down"), (80.0, "on its side")])
def test_motors_that_turn_after_a_crash(roll_deg: float, how: str) -> None:
    flown = Flown()
    flown.up[flown.t >= 41.0] = 0.0
    flown.roll[flown.t >= 41.0] = np.radians(roll_deg)
    broken = flown.broken()
    assert broken is not None
    assert broken.name == "motors_turn_after_a_crash"
    assert broken.time_s == pytest.approx(46.0, abs=0.03)
    assert how in broken.in_words()
    flown.rotor[flown.t >= 45.0] = 0.0  # the driver has stopped what is still commanded
    assert flown.name() == ""
    flown.rotor[:] = 500.0
    flown.armed &= flown.t < 45.0
    flown.turning = flown.armed
    assert flown.name() == ""


def test_a_take_off_that_nobody_asked_for() -> None:
    flown = Flown()
    flown.mode[:] = RETURN
    assert flown.name(ANY) == "unasked_take_off"
    flown.mode[:] = MISSION
    assert flown.name(ANY) == ""
    flown.failsafe[flown.t >= 1.0] = 1.0
    assert flown.name(ANY) == "unasked_take_off"


def test_by_hand_the_stick_asks() -> None:
    flown = Flown()
    flown.mode[:] = POSITION
    flown.throttle[:] = -0.2
    assert flown.name(ANY) == "unasked_take_off"
    flown.throttle[flown.t > 4.9] = 0.5
    assert flown.name(ANY) == ""


def test_a_bounce_is_no_take_off() -> None:
    flown = Flown()
    flown.up += np.interp(flown.t, [50.2, 50.4, 50.6], [0.0, 0.4, 0.0])
    assert flown.name() == ""


def test_outside_the_fence_by_more_than_it_takes_to_brake() -> None:
    flown = Flown()
    flown.north = np.interp(flown.t, [12.0, 24.0, 36.0], [0.0, 60.0, 0.0])
    assert flown.name() == ""  # 5 m/s: 5 m to react, 6 m to brake, and 5 m
    flown.north = np.interp(flown.t, [12.0, 26.0, 38.0], [0.0, 70.0, 0.0])
    assert flown.name() == "outside_the_fence"
    assert flown.name(Setting(origin=(47.0, 8.0), fence_radius=80.0)) == ""
    assert flown.name(Setting(origin=(47.0, 8.0), fence_radius=50.0, cannot_steer_s=15.0)) == ""


def test_above_the_fence() -> None:
    flown = Flown()
    flown.up = np.interp(flown.t, [5.0, 25.0, 28.0, 50.0], [0.0, 45.0, 45.0, 0.0])
    assert flown.name() == "outside_the_fence"


def test_armed_at_the_end() -> None:
    flown = Flown()
    flown.armed[flown.t >= 3.0] = True
    flown.ended = "time_limit"
    assert flown.name() == "armed_at_the_end"
    flown.ended = "restart"
    assert flown.name() == ""


def test_a_mode_that_goes_on_without_its_estimate() -> None:
    flown = Flown()
    lost = (flown.t >= 20.0) & (flown.t < 20.9)
    flown.valid[lost] = 0.0
    assert flown.name() == ""
    flown.valid[(flown.t >= 20.0) & (flown.t < 21.2)] = 0.0
    assert flown.name() == "mode_without_estimate"
    flown.mode[(flown.t >= 20.5) & (flown.t < 22.0)] = 12
    assert flown.name() == ""


def test_what_is_wrong_and_said_to_be_valid() -> None:
    flown = Flown()
    wrong = (flown.t >= 20.0) & (flown.t < 23.0)
    flown.off_m[wrong] = 2.4
    assert flown.name() == ""
    flown.off_m[wrong] = 2.6
    assert flown.name() == "valid_but_wrong"
    assert flown.name(Setting(origin=(47.0, 8.0), unseen_s=19.0)) == ""
    flown.valid[flown.t >= 21.0] = 0.0
    flown.mode[flown.t >= 21.0] = 12
    assert flown.name() == ""


def test_an_origin_that_is_elsewhere_counts() -> None:
    assert Flown().name(Setting(origin=(47.001, 8.0))) == "valid_but_wrong"


def test_the_first_one_counts() -> None:
    flown = Flown()
    flown.off_m[flown.t >= 15.0] = 9.0
    flown.turning &= flown.t < 45.0
    assert flown.name() == "valid_but_wrong"
