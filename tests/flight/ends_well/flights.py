"""Random flights of the quad outdoors: mission, wind and faults from a seed; judged by the
invariants."""

from __future__ import annotations

import argparse
import json
import math
import random
import subprocess
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from pyulog import ULog

from stator import HOME
from stator.build.cmake import build
from stator.flight.arguments import faults_of, setting_of
from stator.flight.invariants import Broken, first_broken
from stator.flight.log import read_truth_columns
from stator.mission.model import EIGHT, LAND, RETURN, TAKEOFF, WAYPOINT, Item, Mission, packed

if TYPE_CHECKING:
    from stator.flight.faults import Fault

GRAPH = HOME / "graph" / "quad_outdoor.yaml"
DURATION_S = 320.0
MOST_WIND_M_S = 12.0


@cache
def program() -> Path:
    return build(GRAPH, "sitl", executor="virtual")


@dataclass(frozen=True)
class Ended:
    seed: int
    faults: list[Fault]
    wind: str
    broken: Broken | None

    def __str__(self) -> str:
        faults = " ".join(map(str, self.faults))
        broken = "" if self.broken is None else self.broken.in_words()
        return f"seed {self.seed}, wind {self.wind}, {faults}: {broken}"


def random_mission(draw: random.Random) -> Mission:
    height = draw.uniform(4.0, 40.0)
    items = [Item(TAKEOFF, 0.0, 0.0, height)]
    for _ in range(draw.randint(1, 4)):
        north, east = draw.uniform(-60.0, 60.0), draw.uniform(-60.0, 60.0)
        height = draw.uniform(4.0, 40.0)
        hold = draw.choice([0.0, 0.0, 3.0, 10.0])
        speed = draw.choice([math.nan, 2.0, 5.0, 8.0])
        items.append(Item(WAYPOINT, north, east, height, hold=hold, speed=speed))
    if draw.random() < 0.2:
        items.append(Item(EIGHT, 0.0, 0.0, height, radius=20.0, hold=1.0, speed=4.0))
    last = draw.choice([RETURN, RETURN, LAND])
    items.append(Item(last, draw.uniform(-30.0, 30.0), draw.uniform(-30.0, 30.0), 0.0))
    return Mission(tuple(items), fence_radius=150.0, fence_height=80.0)


def fly_random(seed: int, folder: Path) -> Ended:
    draw = random.Random(f"flight {seed}")
    mission = random_mission(draw)
    wind = draw.choice([0.0, round(draw.uniform(0.0, MOST_WIND_M_S), 1)])
    gusts = draw.choice(["none", "light", "moderate"]) if wind else "none"
    arguments = argparse.Namespace(
        graph=GRAPH,
        board="sitl",
        fail=[f"random={draw.randint(1, 3)}"],
        seed=seed,
        duration=DURATION_S / 2,
    )
    faults = faults_of(arguments)
    log, truth, file = folder / "f.ulg", folder / "f.truth", folder / "f.mission"
    file.write_bytes(packed(mission))
    command = [program(), "--log", log, "--truth", truth, "--mission", file]
    command += ["--seed", str(seed), "--duration", str(DURATION_S), "--gusts", gusts]
    command += ["--wind", str(wind), "--wind-from", str(draw.randrange(360))]
    command += [word for f in faults for text in f.options() for word in ("--fail", text)]
    finished = subprocess.run(command, check=True, capture_output=True, text=True)
    run = json.loads(finished.stdout)
    setting = setting_of(arguments, mission)
    broken = first_broken(ULog(str(log)), read_truth_columns(truth), run["ended"], setting)
    return Ended(seed, faults, f"{wind:g} {gusts}", broken)
