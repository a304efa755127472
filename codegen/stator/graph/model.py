"""The graph after the checks: complete, consistent, frozen. Times are whole microseconds."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

from stator.diagnostics import Mark
from stator.graph.vehicle import Vehicle
from stator.names import snake, upper_camel

# type name -> (C++ type, ULog type, bytes)
TYPES: dict[str, tuple[str, str, int]] = {
    "bool": ("bool", "bool", 1),
    "float": ("float", "float", 4),
    "double": ("double", "double", 8),
    **{f"int{n}": (f"int{n}_t", f"int{n}_t", n // 8) for n in (8, 16, 32, 64)},
    **{f"uint{n}": (f"uint{n}_t", f"uint{n}_t", n // 8) for n in (8, 16, 32, 64)},
}


@dataclass(frozen=True)
class Field:
    name: str
    type: str
    count: int | None  # None: a single value
    unit: str
    frame: str
    values: tuple[tuple[str, int], ...]
    doc: str

    @property
    def bytes(self) -> int:
        return TYPES[self.type][2] * (self.count or 1)

    @property
    def alignment(self) -> int:
        return TYPES[self.type][2]


@dataclass(frozen=True)
class Message:
    name: str
    doc: str
    fields: tuple[Field, ...]  # with `timestamp` in front and the padding
    mark: Mark

    @property
    def header(self) -> str:
        return snake(self.name)

    @property
    def bytes(self) -> int:
        return sum(field.bytes for field in self.fields)


@dataclass(frozen=True)
class Port:
    name: str
    message: Message
    optional: bool  # an input
    burst: int  # of an output: the highest number of publications in one activation
    min_interval_us: int  # of an output that is published seldom: the usual mean time; else 0
    doc: str


Value = Fraction | int | bool


@dataclass(frozen=True)
class Param:
    name: str
    type: str
    unit: str
    least: Fraction | None
    most: Fraction | None
    default: Value
    doc: str
    is_fixed: bool = False  # while the graph runs
    in_flight: bool = True  # whether it can change while the vehicle is armed
    id: str = ""  # as the interface writes it; empty: it follows from the name
    was: tuple[str, ...] = ()  # former names: of the same node, or NODE.PARAMETER
    values: tuple[tuple[str, int], ...] = ()  # that have names
    flags: tuple[str, ...] = ()  # its bits, the lowest first


@dataclass(frozen=True)
class FailsafeChoice:
    """With this value of a parameter an event leads to other modes than in the table."""

    param: str
    value: int
    event: str
    instead: tuple[tuple[str, str], ...]  # a mode of the event's column, and the one in its place


@dataclass(frozen=True)
class Failsafe:
    """The next flight mode for each flight mode and event: see failsafe.py."""

    file: Path
    modes: tuple[str, ...]
    events: tuple[str, ...]  # most urgent first
    rows: tuple[tuple[str, ...], ...]  # for each mode, the next mode at each event
    disarms: tuple[tuple[bool, ...], ...]  # the same on the ground: whether the event disarms
    needs: dict[str, frozenset[str]]  # what each mode cannot do without
    choices: tuple[FailsafeChoice, ...]


@dataclass(frozen=True)
class BridgeTopic:
    """What one topic is to a node that the compiler generates between machines."""

    port: str
    message: Message
    max_age_us: int  # at the reading end
    period_us: Fraction | None  # mean, if known


@dataclass(frozen=True)
class Bridge:
    """Of a generated node: the sender or the receiver of a link's end, or the selector of a
    standby."""

    kind: str  # sender, receiver, selector
    link: str  # LINK of the class's name in C++, for people; of a selector: the node
    topics: tuple[BridgeTopic, ...]  # on a link: most urgent first; their places are their numbers
    cut: str  # what both ends must agree on, as text

    def period_of(self, port: str) -> Fraction | None:
        return next((t.period_us for t in self.topics if t.port == port), None)


@dataclass(frozen=True)
class Interface:
    """The ports of an app or of a device class."""

    name: str
    file: Path
    doc: str
    lines: dict[str, str]
    inputs: dict[str, Port]
    outputs: dict[str, Port]
    params: dict[str, Param]
    reads_log: bool
    reads_graph: bool
    publishes_params: bool
    reads_metadata: bool
    needs_timer: bool
    double_precision: str  # why it is needed; empty: it is not used
    failsafe: Failsafe | None
    params_message: Message | None
    bridge: Bridge | None = None

    @property
    def is_observer(self) -> bool:
        """Of an app: a replay does not run it, as what it reads is not recorded."""
        return self.reads_log or self.reads_graph

    @property
    def class_name(self) -> str:
        return upper_camel(self.name)

    @property
    def namespace(self) -> str:
        """Of its ports, inside namespace stator: the folder that it stands in."""
        return f"{self.file.parents[1].name}::{self.name}"


@dataclass(frozen=True)
class Device:
    name: str
    driver: str  # "imu/sim", or "none"
    device_class: str
    lines: dict[str, tuple[str, ...]]  # pins or peripherals that raise it
    bus: str
    interface: Interface | None  # None: the class has errors
    bytes_per_s: int | None = None  # of a storage


@dataclass(frozen=True)
class Memory:
    at: int
    bytes: int


@dataclass(frozen=True)
class Chip:
    name: str
    clock_hz: int
    memory: dict[str, Memory]
    vectors: dict[str, int]


@dataclass(frozen=True)
class Upload:
    board_id: int  # for its bootloader and ground stations
    pyocd_target: str | None


@dataclass(frozen=True)
class BoardInterrupt:
    min_interarrival_us: int
    budget_ns: int


@dataclass(frozen=True)
class Costs:
    """What the executor takes beside the nodes. The keys are described in language/keys.py."""

    source: str  # one of PROVENANCES
    task_ns: int
    release_ns: int
    timer_ns: int
    dispatch_ns: int
    line_ns: int
    section_ns: int
    clock_ns: int
    instruction_ns: int | None
    interrupts: dict[str, BoardInterrupt]


@dataclass(frozen=True)
class Board:
    name: str
    file: Path
    executor: str
    chip: Chip | None
    reserved_vectors: tuple[str, ...]
    interrupts: tuple[str, ...]  # vectors whose handlers are the board's own code
    devices: dict[str, Device]
    upload: Upload | None
    costs: Costs | None


@dataclass(frozen=True)
class Budget:
    us: int
    source: str  # one of PROVENANCES


@dataclass(frozen=True)
class Trigger:
    kind: str  # irq, topic, every
    name: str  # the line or the topic; empty for `every`
    mark: Mark
    min_interarrival_us: int | None = None
    min_interval_us: int | None = None
    period_us: int = 0
    offset_us: int = 0
    max_interval_us: int | None = None

    @property
    def is_thinned(self) -> bool:
        return self.min_interval_us is not None


@dataclass(frozen=True)
class NodeInput:
    port: Port
    topic: str
    max_age_us: int | None
    queue: bool
    mark: Mark


@dataclass(frozen=True)
class NodeOutput:
    port: Port
    topic: str
    mark: Mark


@dataclass(frozen=True)
class Link:
    """The wire to another machine."""

    to: str
    here: str  # devices
    there: str
    baud: int
    wake_up_us: int  # of the machine that has the link; 0: an interrupt serves it
    mark: Mark


@dataclass(frozen=True)
class Machine:
    name: str
    board: Board
    link: Link | None  # None: the first machine
    mark: Mark


@dataclass(frozen=True)
class Standby:
    machine: str
    max_age_us: int | None
    mark: Mark


@dataclass(frozen=True)
class Node:
    name: str
    interface: Interface
    device: str | None
    triggers: tuple[Trigger, ...]
    priority: int | None
    deadline_us: int | None
    budget: Budget | None
    inputs: dict[str, NodeInput]
    outputs: dict[str, NodeOutput]
    params: dict[str, Value]
    mark: Mark
    machine: str = ""  # empty: the graph has one machine
    standby: Standby | None = None

    @property
    def budget_us(self) -> int | None:
        return None if self.budget is None else self.budget.us

    def way_of(self, source: NodeInput) -> str:
        """How the node reads an input: trigger, thinned, queue or latest."""
        trigger = self.trigger_of(source.topic)
        if trigger is not None:
            return "thinned" if trigger.is_thinned else "trigger"
        return "queue" if source.queue else "latest"

    def trigger_of(self, topic: str) -> Trigger | None:
        """The topic trigger on this topic, if the node has one."""
        return next((t for t in self.triggers if t.kind == "topic" and t.name == topic), None)


@dataclass(frozen=True)
class TopicConfig:
    log: str | int | None  # "all", "none", a period in us; None: not given
    depth: int | None
    many_publishers: bool
    mark: Mark | None
    link_every_us: int | None = None
    link_priority: int | None = None


@dataclass(frozen=True)
class Topic:
    name: str
    message: Message
    publishers: tuple[str, ...]  # nodes, in graph order
    readers: tuple[tuple[str, str], ...]  # (node, input), in graph order
    config: TopicConfig


@dataclass(frozen=True)
class Modes:
    initial: str
    sets: dict[str, tuple[str, ...]]
    publisher: str


@dataclass(frozen=True)
class Chain:
    name: str
    path: tuple[str, ...]
    deadline_us: int
    mark: Mark


@dataclass(frozen=True)
class Wire:
    """A link with the devices that stand for its ends."""

    near: str  # the end of the machine that has the link
    far: str
    near_machine: str
    link: Link


@dataclass(frozen=True)
class Graph:
    name: str
    file: Path
    doc: str
    board: Board
    vehicle: Vehicle
    nodes: dict[str, Node]
    topics: dict[str, Topic]
    modes: Modes | None
    chains: tuple[Chain, ...]
    files: tuple[Path, ...]  # everything that was read
    machines: dict[str, Machine] = field(default_factory=dict)  # none: there is one
    wires: tuple[Wire, ...] = ()  # of the links, once the compiler has cut the graph

    @property
    def params_publisher(self) -> Node | None:
        """The node that changes parameters while the graph runs."""
        return next((n for n in self.nodes.values() if n.interface.publishes_params), None)

    @property
    def changeable(self) -> dict[str, Node]:
        """The nodes whose parameters it changes: those of its own machine."""
        publisher = self.params_publisher
        return {
            node.name: node
            for node in self.nodes.values()
            if publisher is not None and node.params and node.machine == publisher.machine
        }
