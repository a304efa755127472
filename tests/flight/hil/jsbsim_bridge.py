"""A quadrotor in JSBSim as a simulator with HIL messages: an example of how to connect one.

JSBSim counts in feet and pounds; the messages are in the units of docs/hil.md."""

from __future__ import annotations

import math
import random
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tests.flight.hil.peers import ACCEL, ARMED, BARO, GYRO, MAG, mavlink

from stator import HOME

if TYPE_CHECKING:
    from tests.flight.hil.peers import Peer

HERE = Path(__file__).parent
PACKAGES = HOME / "build" / "jsbsim"  # of its own: only the test of this folder needs them
FEET = 1.0 / 0.3048
HPA = 47.880259e-2  # in a pound for each square foot
STEP_S = 0.001
STEPS = 4  # for each HIL_SENSOR
LATITUDE, LONGITUDE, HEIGHT_M = 47.397742, 8.545594, 488.0
FIELD_N = (0.2164, 0.0125, 0.4328)  # gauss, near Zurich: north, east, down


def install() -> None:
    """JSBSim, pinned, where the test alone looks for it."""
    wanted = HERE / "requirements.txt"
    done = PACKAGES / "requirements.txt"
    if not done.is_file() or done.read_bytes() != wanted.read_bytes():
        pip = [sys.executable, "-I", "-m", "pip", "install", "--quiet", "--upgrade", "--no-deps"]
        pip += ["--only-binary", ":all:", "--target", str(PACKAGES), "-r", str(wanted)]
        finished = subprocess.run(pip, capture_output=True, text=True, check=False)
        assert finished.returncode == 0, finished.stderr
        done.write_bytes(wanted.read_bytes())
    if str(PACKAGES) not in sys.path:
        sys.path.append(str(PACKAGES))


class Quad:
    """The vehicle in JSBSim; N is north, east, down of where it started."""

    def __init__(self) -> None:
        import jsbsim

        jsbsim.FGJSBBase().debug_lvl = 0
        fdm = self.fdm = jsbsim.FGFDMExec(str(HERE / "jsbsim_quad"))
        assert fdm.load_model("quad")
        fdm.set_dt(STEP_S)
        fdm["ic/lat-geod-deg"], fdm["ic/long-gc-deg"] = LATITUDE, LONGITUDE
        fdm["ic/terrain-elevation-ft"] = HEIGHT_M * FEET
        fdm["ic/h-agl-ft"] = 0.1 * FEET  # on its feet
        fdm["ic/psi-true-rad"] = 0.5
        assert fdm.run_ic()
        self.random = random.Random(1)

    def move(self, controls: list[float]) -> None:
        for number, control in enumerate(controls, 1):
            self.fdm[f"fcs/motor-{number}-cmd"] = control
        for _ in range(STEPS):
            assert self.fdm.run()

    def time_us(self) -> int:
        return round(self.fdm["simulation/sim-time-sec"] / STEP_S) * 1000

    def position(self) -> tuple[float, float, float]:
        north = math.radians(self.fdm["position/lat-geod-deg"] - LATITUDE) * 6_367_000.0
        east = math.radians(self.fdm["position/long-gc-deg"] - LONGITUDE) * 6_388_000.0
        return north, east * math.cos(math.radians(LATITUDE)), -self.height()

    def height(self) -> float:
        return float(self.fdm["position/h-agl-ft"]) / FEET

    def tilt_deg(self) -> float:
        level = math.cos(self.fdm["attitude/phi-rad"]) * math.cos(self.fdm["attitude/theta-rad"])
        return math.degrees(math.acos(max(-1.0, min(1.0, level))))

    def field(self) -> tuple[float, float, float]:
        """In body axes: N turned by yaw, pitch and roll."""
        north, east, down = FIELD_N
        psi, theta, phi = (self.fdm[f"attitude/{name}-rad"] for name in ("psi", "theta", "phi"))
        ahead = math.cos(psi) * north + math.sin(psi) * east
        right = -math.sin(psi) * north + math.cos(psi) * east
        forward = math.cos(theta) * ahead - math.sin(theta) * down
        low = math.sin(theta) * ahead + math.cos(theta) * down
        return (
            forward,
            math.cos(phi) * right + math.sin(phi) * low,
            -math.sin(phi) * right + math.cos(phi) * low,
        )

    def sensor(self, fields: int) -> Any:
        def noisy(value: float, sigma: float) -> float:
            return value + self.random.gauss(0.0, sigma)

        accel = [noisy(self.fdm[f"accelerations/a-pilot-{a}-ft_sec2"] / FEET, 0.05) for a in "xyz"]
        gyro = [noisy(self.fdm[f"velocities/{rate}-rad_sec"], 0.002) for rate in "pqr"]
        field = [noisy(value, 0.002) for value in self.field()]
        return mavlink.MAVLink_hil_sensor_message(
            self.time_us(), *accel, *gyro, *field,
            abs_pressure=noisy(self.fdm["atmosphere/P-psf"] * HPA, 0.012),
            diff_pressure=0.0,
            pressure_alt=self.fdm["position/h-sl-ft"] / FEET,
            temperature=self.fdm["atmosphere/T-R"] / 1.8 - 273.15,
            fields_updated=fields,
        )  # fmt: skip

    def fix(self) -> Any:
        speed = [
            round(self.fdm[f"velocities/v-{way}-fps"] / FEET * 100.0)
            for way in ("north", "east", "down")
        ]
        return mavlink.MAVLink_hil_gps_message(
            self.time_us(), 3,
            lat=round(self.fdm["position/lat-geod-deg"] * 1e7),
            lon=round(self.fdm["position/long-gc-deg"] * 1e7),
            alt=round(self.fdm["position/h-sl-ft"] / FEET * 1e3),
            eph=80, epv=120, vel=round(math.hypot(*speed[:2])),
            vn=speed[0], ve=speed[1], vd=speed[2], cog=65535, satellites_visible=12,
        )  # fmt: skip


def simulate(quad: Quad, peer: Peer, most_s: float) -> list[tuple[float, ...]]:
    """In lockstep, until the autopilot closes the connection; rows of time, position and tilt."""
    rows: list[tuple[float, ...]] = []
    for count in range(round(most_s / (STEPS * STEP_S))):
        slow = (MAG if count % 5 == 0 else 0) | (BARO if count % 10 == 0 else 0)
        if count % 50 == 25:
            peer.send(quad.fix())
        peer.send(quad.sensor(ACCEL | GYRO | slow))
        answer = peer.receive("HIL_ACTUATOR_CONTROLS")
        if answer is None:
            break
        armed = bool(answer.mode & ARMED)
        quad.move([float(control) if armed else 0.0 for control in answer.controls[:4]])
        rows.append((quad.time_us() * 1e-6, *quad.position(), quad.tilt_deg()))
    return rows
