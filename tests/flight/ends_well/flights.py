"""Random flights of the quad outdoors: mission, wind and faults from a seed; judged by the
invariants."""

from __future__ import annotations

import argparse
import json
import random
import subprocess
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from pyulog import ULog

from stator import HOME
from stator.build.cmake import build
from stator.flight.arguments import faults_of, memory_of, place_options, setting_of
from stator.flight.invariants import Broken, first_broken
from stator.flight.log import read_truth_columns
from stator.mission.read import read_mission
from stator.mission.vehicle import Vehicle, vehicle_of
from stator.pipeline import make_plan

if TYPE_CHECKING:
    from stator.flight.faults import Fault

GRAPH = HOME / "graph" / "quad_outdoor.yaml"
DURATION_S = 320.0
MOST_WIND_M_S = 12.0


@cache
def program() -> Path:
    return build(GRAPH, "sitl", executor="virtual")


@cache
def vehicle() -> Vehicle:
    return vehicle_of(make_plan(str(GRAPH), "sitl").graph)


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


def random_mission(draw: random.Random) -> str:
    """As the text of a mission."""
    height = draw.uniform(4.0, 40.0)
    items = [f"takeoff: {{height: {height:.1f} m}}"]
    for _ in range(draw.randint(1, 4)):
        north, east = draw.uniform(-60.0, 60.0), draw.uniform(-60.0, 60.0)
        height = draw.uniform(4.0, 40.0)
        place = f"north: {north:.1f} m, east: {east:.1f} m, height: {height:.1f} m"
        hold = draw.choice([0.0, 0.0, 3.0, 10.0])
        speed = draw.choice(["", "speed: 2 m/s", "speed: 5 m/s", "speed: 8 m/s"])
        more = ", ".join([part for part in (f"hold: {hold:g} s" if hold else "", speed) if part])
        items.append(f"waypoint: {{{place}{', ' if more else ''}{more}}}")
    if draw.random() < 0.2:
        items.append("eight: {length: 20 m, laps: 1, speed: 4 m/s}")
    items.append(draw.choice(["return", "return", "land"]))
    rows = "\n".join(f"  - {item}" for item in items)
    return f"items:\n{rows}\nfence: {{radius: 150 m, height: 80 m}}\n"


def fly_random(seed: int, folder: Path) -> Ended:
    draw = random.Random(f"flight {seed}")
    plan = folder / "mission.yaml"
    plan.write_text(random_mission(draw), encoding="utf-8")
    mission = read_mission(plan, vehicle())
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
    log, truth = folder / "f.ulg", folder / "f.truth"
    command = [program(), "--log", log, "--truth", truth]
    command += ["--seed", str(seed), "--duration", str(DURATION_S), "--gusts", gusts]
    command += ["--wind", str(wind), "--wind-from", str(draw.randrange(360))]
    command += [word for f in faults for text in f.options() for word in ("--fail", text)]
    with memory_of(mission) as memory:
        command += ["--mission", str(memory), *place_options(mission)]
        finished = subprocess.run(command, check=True, capture_output=True, text=True)
    run = json.loads(finished.stdout)
    setting = setting_of(arguments, mission)
    broken = first_broken(ULog(str(log)), read_truth_columns(truth), run["ended"], setting)
    return Ended(seed, faults, f"{wind:g} {gusts}", broken)
