"""What each direction of a link carries, and how late a sample can be: as messages on a CAN bus.

One frame is on the wire at a time, and of those that wait the most urgent goes first, so that the
analysis of Davis, Burns, Bril and Lukkien (Real-Time Systems 35, 2007) holds, with the times of a
serial line. All times count from the instant in which the sender has the sample.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING

from stator.graph.model import Graph, Link, Message
from stator.machines.cut import HELLO_PERIOD_US
from stator.quantities import shown

if TYPE_CHECKING:
    from stator.diagnostics import Report
    from stator.graph.model import Bridge, Node

BITS_OF_BYTE = 10
GAP_US = 5  # from the end of a frame to the beginning of the next
HEAD_BYTES = 3
CRC_BYTES = 4
HELLO_BYTES = 28
MOST_LOAD = Fraction(8, 10)


@dataclass(frozen=True)
class Carried:
    topic: str
    bytes: int  # of its frame
    wire_us: Fraction
    period_us: Fraction
    bound_us: int | None = None  # None: there is none


@dataclass(frozen=True)
class Direction:
    sender: str  # machines
    receiver: str
    link: Link
    wake_up_us: int  # of the receiver
    topics: tuple[Carried, ...]  # most urgent first
    hello: Carried

    @property
    def load(self) -> Fraction:
        return sum((c.wire_us / c.period_us for c in (self.hello, *self.topics)), Fraction(0))


def directions(graph: Graph) -> list[Direction]:
    """Of a graph that is cut. Topics of unknown rate are left out."""
    found = []
    for wire in graph.wires:
        near, far = wire.near_machine, wire.link.to
        for sender, receiver, wake_up in ((far, near, wire.link.wake_up_us), (near, far, 0)):
            node = graph.nodes[f"{sender}_{receiver}_sender"]
            found.append(_direction(node, wire.link, sender, receiver, wake_up))
    return found


def _direction(node: Node, link: Link, sender: str, receiver: str, wake_up: int) -> Direction:
    bridge = _bridge(node)
    topics = [
        Carried(
            t.port,
            frame_bytes(HEAD_BYTES + body_bytes(t.message)),
            wire_us(frame_bytes(HEAD_BYTES + body_bytes(t.message)), link),
            t.period_us,
        )
        for t in bridge.topics
        if t.period_us is not None
    ]
    size = frame_bytes(HELLO_BYTES)
    hello = Carried("hello", size, wire_us(size, link), Fraction(HELLO_PERIOD_US))
    bounded = tuple(
        replace(carried, bound_us=bound_us(i, [hello, *topics], wake_up))
        for i, carried in enumerate(topics, 1)
    )
    return Direction(sender, receiver, link, wake_up, bounded, hello)


def _bridge(node: Node) -> Bridge:
    assert node.interface.bridge is not None
    return node.interface.bridge


def body_bytes(message: Message) -> int:
    """What of a message travels: its memory without the padding at its end."""
    last = message.fields[-1]
    return message.bytes - (last.bytes if last.name.startswith("_padding") else 0)


def frame_bytes(count: int) -> int:
    """As in runtime/link/stator/frame.hpp."""
    return count + CRC_BYTES + (count + CRC_BYTES) // 254 + 2


def wire_us(count: int, link: Link) -> Fraction:
    return Fraction(BITS_OF_BYTE * count * 1_000_000, link.baud) + GAP_US


def bound_us(place: int, carried: list[Carried], wake_up_us: int) -> int | None:
    """The longest time from a sample at the sender to its arrival, rounded up."""
    if sum(c.wire_us / c.period_us for c in carried[: place + 1]) >= 1:
        return None
    own, urgent = carried[place], carried[:place]
    blocking = max((c.wire_us for c in carried[place + 1 :]), default=Fraction(0))
    busy = own.wire_us
    while True:
        longer = blocking + sum(-(-busy // c.period_us) * c.wire_us for c in [*urgent, own])
        if longer == busy:
            break
        busy = longer
    worst = Fraction(0)
    for q in range(int(-(-busy // own.period_us))):
        waits = blocking + q * own.wire_us
        while True:
            longer = blocking + q * own.wire_us
            longer += sum((waits // c.period_us + 1) * c.wire_us for c in urgent)
            if longer == waits:
                break
            waits = longer
        worst = max(worst, waits - q * own.period_us + own.wire_us)
    return int(-(-worst // 1)) + wake_up_us


def check_links(graph: Graph, report: Report) -> None:
    """Of a graph that is cut."""
    for direction in directions(graph):
        sender, receiver = direction.sender, direction.receiver
        node = graph.nodes[f"{sender}_{receiver}_sender"]
        for topic in _bridge(node).topics:
            if topic.period_us is None:
                report.error(
                    direction.link.mark,
                    "link-rate",
                    f"cannot compute the load of the link from '{sender}' to '{receiver}': the "
                    f"rate of '{topic.port}' is unknown",
                    f"write `topics: {{{topic.port}: {{link: {{every: 20 ms}}}}}}`",
                )
        if direction.load > MOST_LOAD:
            shares = sorted(direction.topics, key=lambda c: c.wire_us / c.period_us, reverse=True)
            parts = ", ".join(
                f"{c.topic} {percent(c.wire_us / c.period_us)} ({c.bytes} bytes every "
                f"{shown(c.period_us)} us)"
                for c in shares
            )
            report.error(
                direction.link.mark,
                "link-load",
                f"expected a load of at most {percent(MOST_LOAD)} from '{sender}' to "
                f"'{receiver}', found {percent(direction.load)}: {parts}",
                f"thin the largest, for example `topics: {{{shares[0].topic}: {{link: {{every: "
                "20 ms}}}`, or raise `baud`",
            )


def percent(share: Fraction) -> str:
    return f"{float(100 * share):.0f} %"


def link_lines(graph: Graph) -> list[str]:
    """For people: each direction, and what it carries."""
    lines = []
    for direction in directions(graph):
        wake_up = f", of which {direction.wake_up_us} us are `wake_up`" * bool(direction.wake_up_us)
        lines.append(
            f"link {direction.sender} -> {direction.receiver}: {direction.link.baud} baud, load "
            f"{percent(direction.load)}{wake_up.replace(', of which', '; of the bounds')}"
        )
        lines += [
            f"  {c.topic}: {c.bytes} bytes every {shown(c.period_us)} us, at most {c.bound_us} us "
            "on the way"
            for c in direction.topics
        ]
    return lines
