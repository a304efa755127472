"""Where the samples of a view come from: a vehicle that runs, or a log."""

from __future__ import annotations

import bisect
import struct
import threading
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from stator.convert.mcap import LITTLE_ENDIAN, channel_of, ros_type_of
from stator.convert.topics import topics_of
from stator.flight.pictures import open_log
from stator.live.figures import WRAP, chain_latency_us, latest_end_us, measure
from stator.live.link import Link, plan_of
from stator.names import upper_camel
from stator.params.source import Log, Vehicle
from stator.pipeline import make_plan

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from stator.graph.model import Message
    from stator.plan.plan import Plan

Sample = tuple[int, bytes]  # time in us, CDR
State = dict[str, Any]
# What all viewers together may ask the vehicle for, each second.
MOST_REQUESTS = 100
MOST_RATE_HZ = 20.0
STATE_S = 1.0
MOST_POINTS = 600  # of a topic's past, for a plot
PAST_S = 60.0


@dataclass(frozen=True)
class Channel:
    topic: str
    schema: str
    definition: str


class Source(Protocol):
    plan: Plan
    is_log: bool
    channels: list[Channel]

    def parameters(self) -> dict[str, Any]: ...


def channel_of_message(topic: str, message: Message) -> Channel:
    """The memory of a sample is its CDR, so only the definition has to be written."""
    lines = [
        f"{ros_type_of(field.type)}{'' if field.count is None else f'[{field.count}]'} {field.name}"
        for field in message.fields
        if not field.name.startswith("_padding")
    ]
    return Channel(topic, f"stator_msgs/msg/{upper_camel(topic)}", "\n".join(lines) + "\n")


class LiveSource:
    """Looks at the vehicle in a thread of its own. What it asks for has a limit, however many look
    on: `wanted` topics up to 20 times a second, the others about once."""

    is_log = False

    def __init__(self, link: Link, graph: Path | None) -> None:
        self._link, self._lock = link, threading.Lock()
        self._info = link.info()
        self.plan = plan_of(self._info, graph, link.path)
        self._vehicle = Vehicle(link, graph)
        self._names = list(self.plan.topics)
        self.channels = [
            channel_of_message(name, topic.message) for name, topic in self.plan.topics.items()
        ]
        self.wanted: frozenset[str] = frozenset()
        self._ends = threading.Event()
        self._newest: dict[str, tuple[int, int, float]] = {}  # number, time in us, rate in Hz
        self._age_us: dict[str, int] = {}
        self._aged_s: dict[str, float] = {}  # when the age was looked at
        self._chains = self.plan.graph.chains

    def parameters(self) -> dict[str, Any]:
        with self._lock:
            return dict(self._vehicle.values())

    def run(self, take: Callable[[str, Sample], None], tell: Callable[[State], None]) -> None:
        """Until `end`, or until the vehicle is gone, which raises `NoLink`."""
        due = dict.fromkeys(self._names, 0.0)
        state_s = 0.0
        while not self._ends.is_set():
            now_s = time.monotonic()
            if now_s >= state_s:
                state_s = now_s + STATE_S
                tell(self._state())
            name = min(due, key=lambda name: due[name])
            if due[name] > now_s:
                self._ends.wait(min(due[name] - now_s, 1.0 / MOST_REQUESTS))
                continue
            is_wanted = name in self.wanted
            busy_s = len(self.wanted) / (0.5 * MOST_REQUESTS)
            due[name] = now_s + (max(1.0 / MOST_RATE_HZ, busy_s) if is_wanted else STATE_S)
            self._look(name, take)
            self._ends.wait(1.0 / MOST_REQUESTS)

    def end(self) -> None:
        self._ends.set()

    def _look(self, name: str, take: Callable[[str, Sample], None]) -> None:
        with self._lock:
            number, data = self._link.sample(self._names.index(name))
        if len(data) < 8:
            return
        (time_us,) = struct.unpack_from("<Q", data)
        self._look_at_age(name, time_us)
        before = self._newest.get(name)
        if before is not None and before[0] == number:
            return
        rate = 0.0
        if before is not None and time_us > before[1]:
            rate = (number - before[0]) % WRAP * 1e6 / (time_us - before[1])
        self._newest[name] = (number, time_us, rate)
        take(name, (time_us, LITTLE_ENDIAN + data))

    def _look_at_age(self, name: str, time_us: int) -> None:
        """Of the newest sample, by the vehicle's clock: most are older at the next look."""
        now_s = time.monotonic()
        if now_s - self._aged_s.get(name, -STATE_S) < STATE_S:
            return
        self._ends.wait(1.0 / MOST_REQUESTS)
        self._aged_s[name] = now_s
        with self._lock:
            self._age_us[name] = max(self._link.info().time_us - time_us, 0)

    def _state(self) -> State:
        with self._lock:
            time_us, rows = measure(self._link, self._info, self.plan, 0.2)
        topics = {
            name: {"rate_hz": rate, "age_s": self._age_us.get(name, 0) / 1e6}
            for name, (_, _, rate) in self._newest.items()
        }
        return {
            "time_s": time_us / 1e6,
            "measured_in": self._info.unit,
            "tasks": [vars(row) | {"bound_us": latest_end_us(row, self.plan)} for row in rows],
            "topics": topics,
            "chains": [
                {
                    "name": chain.name,
                    "worst_us": chain_latency_us(chain, self.plan, rows),
                    "deadline_us": chain.deadline_us,
                }
                for chain in self._chains
            ],
        }


class LogSource:
    """A log as it was at any time."""

    is_log = True

    def __init__(self, file: Path, graph: Path | None) -> None:
        ulog = open_log(file)
        self._log = Log(file, graph)
        self.plan = make_plan(str(self._log.graph.file), None)
        self._topics = {topic.name: topic for topic in topics_of(ulog, file, [])}
        made = {name: channel_of(topic) for name, topic in self._topics.items()}
        self._message = {name: channel.message for name, channel in made.items()}
        self.channels = [Channel(c.name, c.schema, c.definition) for c in made.values()]
        ends = [t.time_us[i] for t in self._topics.values() if len(t.time_us) for i in (0, -1)]
        self.begin_s, self.end_s = float(min(ends)) / 1e6, float(max(ends)) / 1e6
        self.lines = [
            {"time_s": m.timestamp / 1e6, "level": m.log_level_str(), "text": m.message}
            for m in ulog.logged_messages
        ]

    def parameters(self) -> dict[str, Any]:
        return dict(self._log.values())

    def samples(self, name: str, from_s: float, to_s: float) -> list[Sample]:
        """Those after one time and up to another; of many every nth."""
        times = self._topics[name].time_us
        first = bisect.bisect_right(times, from_s * 1e6)
        last = bisect.bisect_right(times, to_s * 1e6)
        step = max(-(-(last - first) // MOST_POINTS), 1)
        chosen = range(last - 1, first - 1, -step)
        return [(int(times[i]), self._message[name](i)) for i in reversed(chosen)]

    def state(self, at_s: float) -> State:
        topics = {}
        for name, topic in self._topics.items():
            last = bisect.bisect_right(topic.time_us, at_s * 1e6)
            first = bisect.bisect_right(topic.time_us, (at_s - STATE_S) * 1e6)
            if last:
                age_s = at_s - float(topic.time_us[last - 1]) / 1e6
                topics[name] = {"rate_hz": (last - first) / STATE_S, "age_s": age_s}
        return {"time_s": at_s, "tasks": [], "topics": topics, "chains": []}
