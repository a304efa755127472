"""Trim and modes of a vehicle with a wing, from what the plant says of forces alone.

Thrust acts forward through the centre of mass, as in what is published.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from tests.boards.wing.plant_bench import ask, words

from stator.graph.vehicle import GRAVITY, Vehicle

if TYPE_CHECKING:
    from pathlib import Path

    import numpy.typing as npt

    Rows = npt.NDArray[np.float64]

SERVOS = 8


@dataclass(frozen=True)
class Trim:
    """Level, straight and unaccelerated."""

    alpha: float  # rad
    elevator: float  # rad, of all surfaces that only pitch
    thrust: float  # N
    lift: float  # CL
    drag: float  # CD


@dataclass(frozen=True)
class Modes:
    """Frequency in rad/s and damping ratio, or a real eigenvalue in 1/s."""

    short_period: tuple[float, float]
    phugoid: tuple[float, float]
    dutch_roll: tuple[float, float]
    roll: float
    spiral: float


class Mechanics:
    def __init__(self, vehicle: Vehicle, density: float, folder: Path) -> None:
        self.vehicle, self.density, self.folder = vehicle, density, folder
        names = [surface.name for surface in vehicle.surfaces]
        elevators = ["elevator"] if "elevator" in names else names
        self.elevators = [1.0 if name in elevators else 0.0 for name in names]
        self.elevators += [0.0] * (SERVOS - len(names))

    def wrenches(self, motions: Rows, elevator: Rows) -> Rows:
        """Forces and torques of rows of u, v, w, p, q, r."""
        lines = [
            f"wing {words(*motion, self.density, *(e * share for share in self.elevators))}"
            for motion, e in zip(motions, elevator, strict=True)
        ]
        return np.array(ask(self.vehicle, lines, self.folder))

    def trim(self, speed: float) -> Trim:
        """By Newton's method."""
        weight = self.vehicle.mass * GRAVITY
        guess = np.array([0.05, -0.05, 0.15 * weight])
        for _ in range(8):
            tries = guess + np.vstack([np.zeros(3), 1e-6 * np.eye(3)])
            alpha, elevator, thrust = tries.T
            zero = np.zeros(4)
            motions = np.column_stack(
                [speed * np.cos(alpha), zero, speed * np.sin(alpha), zero, zero, zero]
            )
            found = self.wrenches(motions, elevator)
            left = np.column_stack(
                [
                    found[:, 0] + thrust - weight * np.sin(alpha),
                    found[:, 2] + weight * np.cos(alpha),
                    found[:, 4],
                ]
            )
            guess -= np.linalg.solve((left[1:] - left[0]).T / 1e-6, left[0])
        alpha, elevator, thrust = guess
        x, z = found[0, 0], found[0, 2]
        size = 0.5 * self.density * speed**2
        assert self.vehicle.wing is not None
        size *= self.vehicle.wing.area
        return Trim(
            alpha=alpha,
            elevator=elevator,
            thrust=thrust,
            lift=(x * math.sin(alpha) - z * math.cos(alpha)) / size,
            drag=-(x * math.cos(alpha) + z * math.sin(alpha)) / size,
        )

    def rates(self, states: Rows, trim: Trim) -> Rows:
        """Of u, w, q, pitch, v, p, r, roll."""
        vehicle = self.vehicle
        xx, yy, zz, xz = vehicle.inertia
        inertia = np.array([[xx, 0.0, -xz], [0.0, yy, 0.0], [-xz, 0.0, zz]])
        motions = states[:, [0, 4, 1, 5, 2, 6]]
        found = self.wrenches(motions, np.full(len(states), trim.elevator))
        rows = []
        for (u, w, q, pitch, v, p, r, roll), wrench in zip(states, found, strict=True):
            down = [
                -math.sin(pitch),
                math.sin(roll) * math.cos(pitch),
                math.cos(roll) * math.cos(pitch),
            ]
            turning = np.array([p, q, r])
            force = wrench[:3] + np.array([trim.thrust, 0.0, 0.0])
            speeding = force / vehicle.mass + GRAVITY * np.array(down)
            speeding -= np.cross(turning, [u, v, w])
            spinning = np.linalg.solve(inertia, wrench[3:6] - np.cross(turning, inertia @ turning))
            tilting = q * math.cos(roll) - r * math.sin(roll)
            rolling = p + (q * math.sin(roll) + r * math.cos(roll)) * math.tan(pitch)
            rows.append([speeding[0], speeding[2], spinning[1], tilting])
            rows[-1] += [speeding[1], spinning[0], spinning[2], rolling]
        return np.array(rows)

    def modes(self, speed: float, trim: Trim) -> Modes:
        level = np.zeros(8)
        level[[0, 1, 3]] = speed * math.cos(trim.alpha), speed * math.sin(trim.alpha), trim.alpha
        step = 1e-5 * np.eye(8)
        slopes = (self.rates(level + step, trim) - self.rates(level - step, trim)).T / 2e-5
        slow, fast = sorted(_pairs(slopes[:4, :4]))
        (dutch_roll,) = _pairs(slopes[4:, 4:])
        real = [float(e.real) for e in np.linalg.eigvals(slopes[4:, 4:]) if abs(e.imag) < 1e-9]
        return Modes(fast, slow, dutch_roll, min(real), max(real))


def _pairs(slopes: Rows) -> list[tuple[float, float]]:
    values = [complex(e) for e in np.linalg.eigvals(slopes) if e.imag > 1e-9]
    return [(abs(e), -e.real / abs(e)) for e in values]
