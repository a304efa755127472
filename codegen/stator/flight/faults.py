"""What can fail in a simulated flight of a graph: `--fail PART.FAULT[=VALUE]@S[+S]`.

PART is a device of the graph, one of its motors or control surfaces, another node, or the wind.
Here stand the names, their usual values and their ranges; the simulated world
(boards/world/faults.cpp) makes them happen.
"""

from __future__ import annotations

import contextlib
import difflib
import math
import random
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from stator.diagnostics import UserError

if TYPE_CHECKING:
    from stator.plan.plan import Plan

LATEST_S = 1e6
RANDOM = "random"
MOST_RANDOM = 8


class Usual(NamedTuple):
    """A fault's usual value, and the least and the most."""

    value: float | None = None  # None: it takes no value
    least: float = 0.0
    most: float = 1e6


NONE = Usual()
# Of each device class: its quantities, whether a quantity has axes, and the size of an error that
# is felt in flight.
QUANTITIES = {
    "imu": {"gyro": (True, 0.2), "accel": (True, 3.0)},  # rad/s, m/s^2
    "gnss": {"position": (True, 10.0), "velocity": (True, 2.0)},  # m, m/s
    "baro": {"pressure": (False, 100.0)},  # Pa
    "mag": {"field": (True, 0.2)},  # gauss
    "airspeed": {"pressure": (False, 30.0)},  # Pa; 2 m/s at 15 m/s
    "mocap": {"position": (True, 0.2), "yaw": (False, 0.5)},  # m, rad
    "battery": {"remaining": (False, 0.2), "voltage": (False, 1.0)},
}
# What can happen to a quantity: its usual value in sizes, and whether the value may be negative.
OF_QUANTITY: dict[str, tuple[float | None, bool]] = {
    "offset": (1.0, True),
    "drift": (0.1, True),
    "noise": (0.5, False),
    "spike": (10.0, True),
    "saturation": (2.0, False),
    "wrong_sign": (None, False),
}
OF_SENSOR = {
    "stuck": NONE,
    "drop_out": NONE,
    "delay": Usual(0.3, most=60.0),
    "time_jump": Usual(0.5, most=1e6),
}
NODE = "node"
OF_NODE = {"stuck": NONE}  # it does not run, and its outputs keep what they have
OF_SERVO = {"loss": NONE, "stuck": NONE}  # it hangs in the wind, or stays where it is
LINK = "link"
MACHINE = "machine"
OF_LINK = {"cut": NONE, "noise": Usual(1e-4, most=1.0)}  # of all links; noise: damaged bytes
OF_MACHINE = {"kill": NONE, "freeze": NONE}  # it starts again as at first, or goes on
OF_MOTOR = {"loss": NONE, "partial": Usual(0.5, most=1.0), "stuck": NONE}
OF_OTHERS = {
    "motor": OF_MOTOR,
    "servo": OF_SERVO,
    NODE: OF_NODE,
    LINK: OF_LINK,
    MACHINE: OF_MACHINE,
}
SPECIAL: dict[str, dict[str, Usual]] = {
    "gnss": {
        "loss": NONE,
        "glitch": Usual(20.0, most=1e5),
        "spoof": Usual(0.5, least=-100.0, most=100.0),
        "multipath": Usual(10.0, most=1e5),
    },
    "airspeed": {  # the tube with its drain, the static port
        "blocked": NONE,
        "trapped": NONE,
        "static_blocked": NONE,
        "ice": Usual(30.0, least=0.1, most=1e4),  # s, until nothing is left
    },
    "radio": {"loss": NONE, "silence": NONE, "preset": NONE, "stuck_stick": NONE},
    "battery": {
        "low": Usual(0.1, most=1.0),
        "sag": Usual(0.8, most=1.0),
        "weak_supply": Usual(20.0, most=1e4),
        "dead": NONE,
    },
    "mission": {"loss": NONE},
    "wind": {"speed": Usual(10.0, most=100.0)},
}
# Names of before, which stay: the part and the fault that each stands for.
SHORT = {
    "gnss_loss": ("gnss", "loss"),
    "gnss_glitch": ("gnss", "glitch"),
    "baro_loss": ("baro", "drop_out"),
    "mission_loss": ("mission", "loss"),
    "rc_loss": ("radio", "loss"),
    "battery_low": ("battery", "low"),
}
# Names that the flight program has for some of them.
OWN = {
    ("gnss", "loss"): "gnss_loss",
    ("gnss", "glitch"): "gnss_glitch",
    ("mission", "loss"): "mission_loss",
    ("radio", "loss"): "rc_loss",
    ("battery", "low"): "battery_low",
}
# Nothing in the graph can show these.
UNSEEN = ("spoof",)


@dataclass(frozen=True)
class Fault:
    part: str
    name: str
    value: float | None
    from_s: float
    lasts_s: float  # infinite: for good
    device_class: str
    own_part: str = ""  # the flight program's name of the part, if it has another

    def __str__(self) -> str:
        value = "" if self.value is None else f"={self.value:g}"
        lasts = "" if math.isinf(self.lasts_s) else f"+{self.lasts_s:g}"
        return f"{self.part}.{self.name}{value}@{self.from_s:g}{lasts}"

    @property
    def is_unseen(self) -> bool:
        return self.name in UNSEEN

    @property
    def is_of_node(self) -> bool:
        return self.device_class == NODE

    @property
    def takes_steering_away(self) -> bool:
        return self.device_class in ("motor", "servo", "wind", NODE, LINK, MACHINE) or (
            self.device_class == "battery" and self.name in ("low", "sag", "weak_supply", "dead")
        )

    def options(self) -> list[str]:
        """As the flight program reads it; some are several of its faults."""
        lasts = "" if math.isinf(self.lasts_s) else f"+{self.lasts_s:.6f}"
        when = f"@{self.from_s:.6f}{lasts}"
        value = "" if self.value is None else f"={self.value:.9g}"
        if self.name == "spoof":  # away to the north, with the velocity that belongs to it
            names = ["position_x_drift", "velocity_x_offset"]
            return [f"{self.part}.{name}{value}{when}" for name in names]
        if self.name == "multipath":
            assert self.value is not None
            names = [f"position_offset={self.value:.9g}", f"position_noise={self.value / 2:.9g}"]
            return [f"{self.part}.{name}{when}" for name in names]
        if self.device_class == "motor" and self.name == "stuck":
            return [f"{self.part}.motor_stuck{when}"]
        if self.device_class == NODE:
            return [f"{self.part}.hang{when}"]
        own = OWN.get((self.device_class, self.name))
        part = self.own_part or self.part
        return [f"{own or f'{part}.{self.name}'}{value}{when}"]


class Faults:
    """All that can fail in flights of one graph."""

    def __init__(self, plan: Plan) -> None:
        self.classes: dict[str, str] = {}  # of each part
        self.motors = plan.graph.vehicle.motor_count
        self.servos: list[str] = []  # of each surface
        has_motors = False
        for node in plan.graph.nodes.values():
            if node.interface.name == "can_esc":
                has_motors = True
            if node.device is None:
                self.classes[node.name] = NODE
                continue
            kind = plan.board.devices[node.device].device_class
            has_motors |= kind == "motor"
            if kind in QUANTITIES or kind in SPECIAL:
                self.classes[node.device] = kind
            if kind == "servo":
                self.servos = [surface.name for surface in plan.graph.vehicle.surfaces]
        self.classes |= dict.fromkeys(self.servos, "servo")
        if has_motors:
            self.classes |= {f"motor_{i + 1}": "motor" for i in range(self.motors)}
        self.classes["wind"] = "wind"
        if plan.graph.wires:
            machines = list(plan.graph.machines)[1:]
            self.classes |= {LINK: LINK} | dict.fromkeys(machines, MACHINE)

    def of_part(self, part: str) -> dict[str, Usual]:
        kind = self.classes[part]
        if kind in OF_OTHERS:
            return OF_OTHERS[kind]
        known = dict(SPECIAL.get(kind, {}))
        quantities = QUANTITIES.get(kind, {})
        if quantities:
            known |= OF_SENSOR
        for quantity, (has_axes, size) in quantities.items():
            only = len(quantities) == 1
            for prefix in _prefixes(quantity, has_axes=has_axes, only=only):
                known |= _of_quantity(prefix, size)
            if has_axes:
                known |= {"swapped_axis": NONE, f"{quantity}_swapped_axis": NONE}
        if len(quantities) > 1:
            size = next(iter(quantities.values()))[1]
            known |= _of_quantity("", size)
        return known

    def in_words(self) -> str:
        """What this graph has, shortly."""
        lines = []
        nodes = [part for part, kind in self.classes.items() if kind == NODE]
        for part, kind in self.classes.items():
            if kind == NODE:
                continue
            names = list(SPECIAL.get(kind, OF_OTHERS.get(kind, {})))
            quantities = QUANTITIES.get(kind, {})
            if quantities:
                names += [*OF_SENSOR, *OF_QUANTITY]
                if any(has_axes for has_axes, _ in quantities.values()):
                    names.append("swapped_axis")
            more = ""
            if len(quantities) > 1:
                more = f"; of one quantity: {' or '.join(f'{q}_offset' for q in quantities)}"
            lines.append(f"  {part}: {', '.join(names)}{more}")
        short = [name for name, (kind, _) in SHORT.items() if kind in self.classes.values()]
        if "motor_1" in self.classes:
            short.append(f"motor_1 to motor_{self.motors}[=0..1]")
        lines.append(f"  a node ({', '.join(nodes)}): {', '.join(OF_NODE)}")
        return "\n".join([*lines, f"  short: {', '.join(short)}"])

    def read(self, text: str) -> Fault:
        """Raises `UserError`."""
        what, at, when = text.partition("@")
        name, equals, number = what.partition("=")
        from_s, lasts_s = _times(text, when if at else "")
        part, fault = self._part_of(text, name)
        known = self.of_part(part)
        if fault not in known:
            near = difflib.get_close_matches(fault, known, n=1)
            hint = f"did you mean '{part}.{near[0]}'?\n" if near else ""
            raise UserError(
                f"error: --fail {text}: unknown fault '{fault}' of {part}\nhint: {hint}"
                f"this graph has\n{self.in_words()}"
            )
        usual = known[fault]
        value = usual.value
        if equals:
            value = _value(text, number, usual)
        return self._fault(part, fault, value, from_s, lasts_s)

    def _fault(
        self, part: str, name: str, value: float | None, from_s: float, lasts_s: float
    ) -> Fault:
        kind = self.classes[part]
        own = f"servo_{self.servos.index(part) + 1}" if kind == "servo" else ""
        return Fault(part, name, value, from_s, lasts_s, kind, own)

    def _part_of(self, text: str, name: str) -> tuple[str, str]:
        part, dot, fault = name.rpartition(".")
        if not dot and name in SHORT:
            kind, fault = SHORT[name]
            part = next((p for p, k in self.classes.items() if k == kind), "")
        elif not dot and self.classes.get(name) == "motor":
            part, fault = name, "partial"
        if part not in self.classes:
            raise UserError(
                f"error: --fail {text}: unknown part '{part or name}' of this graph\n"
                f"hint: write PART.FAULT[=VALUE]@SECONDS[+SECONDS]; this graph has\n"
                f"{self.in_words()}"
            )
        return part, fault

    def draw(self, count: int, seed: int, longest_s: float) -> list[Fault]:
        """Some faults at random times; always the same ones for a seed. Of what the vehicle has and
        meets: nodes that get stuck are faults of the software."""
        draw = random.Random(f"faults {seed}")
        parts = sorted(part for part, kind in self.classes.items() if kind != NODE)
        found = []
        for _ in range(count):
            part = draw.choice(parts)
            name = draw.choice(sorted(self.of_part(part)))
            usual = self.of_part(part)[name]
            value = usual.value
            if value is not None:
                value = min(round(value * draw.uniform(0.5, 2.0), 3), usual.most)
            from_s = round(draw.uniform(5.0, max(longest_s, 10.0)), 1)
            lasts_s = draw.choice([0.3, 1.0, 3.0, 10.0, 30.0, math.inf])
            found.append(self._fault(part, name, value, from_s, lasts_s))
        return found


def read_faults(plan: Plan, texts: list[str], seed: int, longest_s: float) -> list[Fault]:
    """Raises `UserError`."""
    known = Faults(plan)
    found: list[Fault] = []
    for text in texts:
        if text.partition("=")[0] == RANDOM:
            found += known.draw(_count(text), seed, longest_s)
        else:
            found.append(known.read(text))
    return found


def unseen(faults: list[Fault]) -> list[str]:
    """The faults that no sensor of the graph can show."""
    return [str(fault) for fault in faults if fault.is_unseen]


# --- parts ---


def _prefixes(quantity: str, *, has_axes: bool, only: bool) -> list[str]:
    names = [f"{quantity}_", *([""] if only else [])]
    axes = ["", "x_", "y_", "z_"] if has_axes else [""]
    return [f"{name}{axis}" for name in names for axis in axes]


def _of_quantity(prefix: str, size: float) -> dict[str, Usual]:
    known = {}
    for name, (sizes, is_signed) in OF_QUANTITY.items():
        if sizes is None:
            known[f"{prefix}{name}"] = NONE
        else:
            least = -1e6 if is_signed else 0.0
            known[f"{prefix}{name}"] = Usual(round(sizes * size, 6), least=least)
    return known


def _times(text: str, when: str) -> tuple[float, float]:
    start, plus, lasts = when.partition("+")
    from_s, lasts_s = _seconds(start), _seconds(lasts) if plus else math.inf
    if from_s is None or lasts_s is None:
        raise UserError(
            f"error: --fail {text}: expected PART.FAULT[=VALUE]@SECONDS or @SECONDS+SECONDS, "
            f"found '{text}'\nhint: for example baro0.stuck@20+5, or random=3 without a time"
        )
    return from_s, lasts_s


def _seconds(text: str) -> float | None:
    with contextlib.suppress(ValueError):
        if 0.0 <= float(text) <= LATEST_S:
            return float(text)
    return None


def _value(text: str, number: str, usual: Usual) -> float:
    if usual.value is None:
        raise UserError(
            f"error: --fail {text}: expected no value, found '{number}'\nhint: remove ={number}"
        )
    with contextlib.suppress(ValueError):
        if usual.least <= float(number) <= usual.most:
            return float(number)
    raise UserError(
        f"error: --fail {text}: expected a value from {usual.least:g} to {usual.most:g}, found "
        f"'{number}'\nhint: the usual one is {usual.value:g}"
    )


def _count(text: str) -> int:
    number = text.partition("=")[2]
    if number.isascii() and number.isdigit() and 1 <= int(number) <= MOST_RANDOM:
        return int(number)
    raise UserError(
        f"error: --fail {text}: expected random=1 to random={MOST_RANDOM}, found '{text}'\n"
        "hint: --fail random=3 draws three faults and their times from the seed"
    )
