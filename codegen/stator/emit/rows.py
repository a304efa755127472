"""Flat rows of ready strings for the templates, which only substitute and loop."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from stator import HOME
from stator.emit.readers import is_woken
from stator.graph.checks.parts import MODE_TOPIC
from stator.graph.failsafe import GO_ON
from stator.graph.model import TYPES, Failsafe, Field, Interface, Message, Value
from stator.names import upper_camel
from stator.plan.log_rate import blocks_at_once
from stator.plan.rates import Rates

if TYPE_CHECKING:
    from pathlib import Path

    from stator.graph.model import Node
    from stator.plan.plan import Plan, Task
    from stator.plan.topics import TopicPlan

WORD_BITS = 64
VECTOR_WORD_BITS = 32
COLUMNS = 100
LONGEST_FAST_US = 4_000  # the longest period of a task whose speed matters


# --- messages and ports ---


@dataclass(frozen=True)
class EnumValue:
    name: str
    value: int


@dataclass(frozen=True)
class FieldRow:
    name: str
    line: str  # of the struct
    enum: str  # its type, if it has one of its own
    values: list[EnumValue]
    offset: int


@dataclass(frozen=True)
class PortsRow:
    """What a node sees; lines of a struct, but for `headers` and `params`."""

    class_name: str
    namespace: str
    headers: list[str]
    lines: list[str]
    inputs: list[str]
    params: str  # the message of the parameters; empty: none
    outputs: list[str]


def messages(interfaces: list[Interface]) -> list[Message]:
    """All messages that the interfaces name, by name."""
    found: dict[str, Message] = {}
    for interface in interfaces:
        for port in (*interface.inputs.values(), *interface.outputs.values()):
            found[port.message.name] = port.message
        if interface.params_message is not None:
            found[interface.params_message.name] = interface.params_message
    return [found[name] for name in sorted(found)]


def interfaces(plan: Plan) -> list[Interface]:
    """Those of the nodes, and of all the board's drivers, as the board knows every one of these."""
    found = {node.interface.name: node.interface for node in plan.graph.nodes.values()}
    for device in plan.board.devices.values():
        if device.driver != "none" and device.interface is not None:
            found[device.interface.name] = device.interface
    return [found[name] for name in sorted(found)]


def fields(message: Message, defaults: dict[str, str]) -> list[FieldRow]:
    """`defaults`: literals of the fields that do not start at zero."""
    offset = 0
    result = []
    for field in message.fields:
        result.append(
            FieldRow(
                name=field.name,
                line=commented(
                    f"{_cpp_type(field)} {field.name}{{{defaults.get(field.name, '')}}};",
                    _comment(field),
                ),
                enum=upper_camel(field.name) if field.values else "",
                values=[EnumValue("k" + upper_camel(k), v) for k, v in field.values],
                offset=offset,
            )
        )
        offset += field.bytes
    return result


def defaults(interfaces: list[Interface], message: Message) -> dict[str, str]:
    """Parameters start at their interface's defaults."""
    for interface in interfaces:
        if interface.params_message == message:
            return {p.name: literal(p.default) for p in interface.params.values()}
    return {}


def _cpp_type(field: Field) -> str:
    # An array of one is written as one number: compilers clear the whole message for an empty list.
    if field.name.startswith("_padding") and field.bytes in (1, 2, 4):
        return f"uint{8 * field.bytes}_t"
    single = upper_camel(field.name) if field.values else TYPES[field.type][0]
    return single if field.count is None else f"std::array<{single}, {field.count}>"


def _comment(field: Field) -> str:
    parts = [field.unit if field.unit not in ("", "1") else "", field.frame]
    unit = ", ".join(part for part in parts if part)
    text = one_line(field.doc)
    return f"{text} [{unit}]" if unit else text


def commented(code: str, comment: str, indent: int = 4) -> str:
    """A line of code with its comment behind it, or above it where that would be too long."""
    space = " " * indent
    line = f"{space}{code}  // {comment}" if comment else space + code
    if len(line) <= COLUMNS:
        return line
    return wrapped(comment, indent) + f"\n{space}{code}"


def wrapped(text: str, indent: int = 0) -> str:
    """Text as // comments."""
    space = " " * indent + "// "
    return textwrap.fill(one_line(text), COLUMNS, initial_indent=space, subsequent_indent=space)


def one_line(text: str) -> str:
    """Text that stays inside a // comment whatever it holds."""
    return " ".join(text.split()).replace("\\", "/")


def ports(interface: Interface) -> PortsRow:
    used = {p.message.header for p in (*interface.inputs.values(), *interface.outputs.values())}
    params = interface.params_message
    return PortsRow(
        class_name=interface.class_name,
        namespace=f"stator::{interface.namespace}",
        headers=sorted(used | ({params.header} if params else set())),
        lines=[
            commented(f"bool {name} = false;", one_line(doc), 8)
            for name, doc in interface.lines.items()
        ],
        inputs=[
            commented(f'Input<{p.message.name}> {p.name}{{"{p.name}"}};', one_line(p.doc))
            for p in interface.inputs.values()
        ],
        params=params.name if params else "",
        outputs=[
            commented(f"Output<{p.message.name}> {p.name}{{}};", one_line(p.doc))
            for p in interface.outputs.values()
        ],
    )


# --- pending bits ---


def pend(plan: Plan, task: Task) -> str:
    word, bit = _place(plan, task)
    return f"{{{word}, {1 << bit:#x}}}"


def pends(plan: Plan, woken: list[Task], thinned: list[Task]) -> list[str]:
    """One entry for each pending word of the subscribers, with the bits that are always set. The
    word of the most urgent task comes first."""
    words: dict[int, int] = {}
    for task in sorted((*woken, *thinned), key=lambda task: task.index):
        word, bit = _place(plan, task)
        words[word] = words.get(word, 0) | (1 << bit if task in woken else 0)
    return [f"{{{word}, {mask:#x}}}" for word, mask in words.items()]


def _place(plan: Plan, task: Task) -> tuple[int, int]:
    """Word and bit of a task. Bare metal: its vector. Threads: its place in its level. Else: its
    place in the order of urgency."""
    if plan.board.executor == "pthread":
        return plan.levels.index(task.level), task.index - task.level_begin
    if plan.board.executor == "cortex_m" and task.vector is not None:
        return divmod(task.vector, VECTOR_WORD_BITS)
    return divmod(task.index, WORD_BITS)


# --- topics ---


@dataclass(frozen=True)
class ThinnedRow:
    node: str
    interval_us: int
    pend: str


@dataclass(frozen=True)
class TopicRow:
    name: str
    message: str
    header: str
    depth: int
    slots: int
    ceiling: int
    ring: int  # entries of the ring; 0: depth 1 needs none
    takes_turns: bool
    wakes: bool  # readers that take what woke them
    subscribers: list[str]
    thinned: list[ThinnedRow]


def topic(plan: Plan, planned: TopicPlan) -> TopicRow:
    woken: list[Task] = []
    intervals: dict[str, int] = {}
    for name, _ in planned.readers:
        trigger = plan.graph.nodes[name].trigger_of(planned.name)
        if trigger is None:
            continue
        if trigger.min_interval_us is None:
            woken.append(plan.task(name))
        else:
            intervals[name] = trigger.min_interval_us
    thinned = [plan.task(name) for name in intervals]
    readers = [(name, port) for name, port in planned.readers if not planned.owner]
    return TopicRow(
        name=planned.name,
        message=planned.message.name,
        header=planned.message.header,
        depth=planned.depth,
        slots=planned.slots,
        ceiling=planned.ceiling,
        ring=2 * planned.depth if planned.depth > 1 else 0,
        takes_turns=planned.takes_turns,
        wakes=any(is_woken(plan, plan.task(name), port) for name, port in readers),
        # With threads, thinned tasks are pended elsewhere.
        subscribers=pends(plan, woken, [] if plan.board.executor == "pthread" else thinned),
        thinned=[ThinnedRow(t.node.name, intervals[t.node.name], pend(plan, t)) for t in thinned],
    )


# --- modes, log ---


@dataclass(frozen=True)
class ModeSet:
    name: str
    runs: str  # of each gated node, whether it runs


@dataclass(frozen=True)
class ModesRow:
    gated: list[str]
    sets: list[ModeSet]
    topic: str
    initial: int


@dataclass(frozen=True)
class LogTopicRow:
    name: str
    format: str
    interval_us: int
    bytes: int
    floats: list[str]


@dataclass(frozen=True)
class LogParameterRow:
    name: str
    is_float: str
    value: str  # four bytes


@dataclass(frozen=True)
class LogRow:
    topics: list[LogTopicRow]
    parameters: list[LogParameterRow]
    blocks_at_once: int


def literal(value: Value) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, Fraction):
        return f"{float(value)!r}F"
    return str(value)


def modes(plan: Plan) -> ModesRow:
    graph_modes = plan.graph.modes
    assert graph_modes is not None
    gated = [
        node
        for node in plan.graph.nodes
        if any(node in names for names in graph_modes.sets.values())
    ]
    sets = [
        ModeSet(name, ", ".join("true" if node in names else "false" for node in gated))
        for name, names in graph_modes.sets.items()
    ]
    return ModesRow(gated, sets, MODE_TOPIC, list(graph_modes.sets).index(graph_modes.initial))


def log(plan: Plan) -> LogRow | None:
    if not any(node.interface.reads_log for node in plan.graph.nodes.values()):
        return None
    return LogRow(
        topics=[
            LogTopicRow(
                name=t.name,
                format=_log_format(t.message),
                interval_us=t.log_us,
                bytes=sum(field.bytes for field in _logged_fields(t.message)),
                floats=log_floats(t.message),
            )
            for t in plan.topics.values()
            if t.log_us is not None
        ],
        parameters=[
            _log_parameter(node, key) for node in plan.graph.nodes.values() for key in node.params
        ],
        blocks_at_once=blocks_at_once(plan.graph, plan.topics),
    )


@dataclass(frozen=True)
class ObservedTopicRow:
    name: str
    format: str
    bytes: int


def observed(plan: Plan) -> list[ObservedTopicRow]:
    """The topics that people know: parameters of nodes have commands of their own."""
    return [
        ObservedTopicRow(
            topic.name,
            _log_format(topic.message),
            sum(field.bytes for field in _logged_fields(topic.message)),
        )
        for topic in sorted(plan.topics.values(), key=lambda topic: topic.name)
        if not topic.owner
    ]


def _logged_fields(message: Message) -> tuple[Field, ...]:
    """Without the padding at the end, which readers of ULog do not expect in the data."""
    last = message.fields[-1]
    return message.fields[:-1] if last.name.startswith("_padding") else message.fields


def _log_format(message: Message) -> str:
    parts = []
    for field in _logged_fields(message):
        count = "" if field.count is None else f"[{field.count}]"
        parts.append(f"{TYPES[field.type][1]}{count} {field.name};")
    return "".join(parts)


def log_floats(message: Message) -> list[str]:
    runs: list[tuple[int, int, int]] = []  # offset, count, bytes of one
    offset = 0
    for field in message.fields:
        if field.type in ("float", "double"):
            size, count = TYPES[field.type][2], field.count or 1
            if runs and runs[-1][0] + runs[-1][1] * runs[-1][2] == offset and runs[-1][2] == size:
                runs[-1] = (runs[-1][0], runs[-1][1] + count, size)
            else:
                runs.append((offset, count, size))
        offset += field.bytes
    return [f"{{{offset}, {count}, {size}}}" for offset, count, size in runs]


def _log_parameter(node: Node, key: str) -> LogParameterRow:
    is_float = node.interface.params[key].type == "float"
    value = node.params[key]
    return LogParameterRow(
        name=f"{node.name}.{key}",
        is_float="true" if is_float else "false",
        value=literal(value) if is_float else str(int(value)),
    )


# --- the program and its build ---


@dataclass(frozen=True)
class WatchedRow:
    name: str
    task: int
    window_us: int
    gate: str


@dataclass(frozen=True)
class ProgramRow:
    """Of the virtual executor."""

    words: int  # of pending bits
    level_begin: list[int]
    task_count: int
    watched: list[WatchedRow]


@dataclass(frozen=True)
class ModeAfter:
    mode: str
    nexts: list[str]
    disarms: list[str]  # on the ground: C++ literals


@dataclass(frozen=True)
class ModeInstead:
    when: str  # C++ condition
    next: str


@dataclass(frozen=True)
class FailsafeRow:
    namespace: str
    events: list[str]
    rows: list[ModeAfter]
    instead: list[ModeInstead]


@dataclass(frozen=True)
class CMakeLibrary:
    name: str
    ports: str  # the interface whose ports it has
    folder: str


@dataclass(frozen=True)
class Small:
    """What an image has optimised for size."""

    libraries: list[str]
    sources: list[str]


@dataclass(frozen=True)
class BuildRow:
    """What CMake must know of a graph."""

    executor: str
    board: str
    chip: str
    sources: list[str]
    libraries: list[CMakeLibrary]
    roots: list[str]  # where apps/ and drivers/ are
    inputs: list[str]
    small: Small


def program(plan: Plan) -> ProgramRow:
    begins = []
    for level in range(16):
        # A level without tasks begins at the same index as the next lower one.
        begins.append(sum(1 for task in plan.tasks if task.level > level))
    return ProgramRow(
        words=max(1, -(-len(plan.tasks) // WORD_BITS)),
        level_begin=begins,
        task_count=len(plan.tasks),
        watched=watched(plan),
    )


def _chip_folder(plan: Plan) -> Path:
    """Where the code lies that all boards with such a chip share."""
    assert plan.board.chip is not None
    return plan.board.file.parents[1] / plan.board.chip.name.split("/")[0]


def watched(plan: Plan) -> list[WatchedRow]:
    """Tasks that must show life, and how often; unbound drivers never do."""
    gated = set(modes(plan).gated) if plan.graph.modes is not None else set()
    return [
        WatchedRow(
            name=task.node.name,
            task=task.index,
            window_us=task.window_us,
            gate=f"&tasks::{task.node.name}::state.gate" if task.node.name in gated else "nullptr",
        )
        for task in plan.tasks
        if task.window_us is not None and _is_bound(plan, task.node)
    ]


def _is_bound(plan: Plan, node: Node) -> bool:
    return node.device is None or plan.board.devices[node.device].driver != "none"


def failsafe(interface: Interface, table: Failsafe) -> FailsafeRow:
    return FailsafeRow(
        namespace=f"stator::{interface.namespace}",
        events=[upper_camel(event) for event in table.events],
        rows=[
            ModeAfter(
                upper_camel(mode),
                [upper_camel(following) for following in row],
                ["true" if disarms else "false" for disarms in on_ground],
            )
            for mode, row, on_ground in zip(table.modes, table.rows, table.disarms, strict=True)
        ],
        instead=[
            ModeInstead(
                f"event == FailsafeEvent::k{upper_camel(choice.event)} && "
                f"params.{choice.param} == {choice.value} && next == Nav::k{upper_camel(mode)}",
                "mode" if following == GO_ON else f"Nav::k{upper_camel(following)}",
            )
            for choice in table.choices
            for mode, following in choice.instead
        ],
    )


def build(plan: Plan, files: dict[str, str]) -> BuildRow:
    nodes = _apps(plan)
    for device in plan.board.devices.values():
        if device.driver != "none" and device.interface is not None:
            nodes[device.driver] = device.interface
    chip = "" if plan.board.chip is None else str(_chip_folder(plan))
    return _build(plan, plan.board.executor, plan.board.file.parent, chip, files, nodes)


def replay_build(plan: Plan, files: dict[str, str]) -> BuildRow:
    """No driver and no observer; the executor brings its own program."""
    apps = {name: app for name, app in _apps(plan).items() if not app.is_observer}
    return _build(plan, "replay", HOME / "runtime" / "replay", "", files, apps)


def _apps(plan: Plan) -> dict[str, Interface]:
    return {
        node.interface.name: node.interface
        for node in plan.graph.nodes.values()
        if node.device is None and node.interface.bridge is None
    }


def _build(
    plan: Plan,
    executor: str,
    board: Path,
    chip: str,
    files: dict[str, str],
    nodes: dict[str, Interface],
) -> BuildRow:
    """`nodes`: the folder of each app and driver, below apps/ or drivers/, and its ports."""
    return BuildRow(
        executor=executor,
        board=str(board),
        chip=chip,
        sources=[name for name in files if name.endswith(".cpp")],
        libraries=_libraries(nodes),
        roots=_roots(nodes),
        inputs=sorted({str(path) for path in (*plan.graph.files, plan.board.file)}),
        small=_small(plan, files) if executor == "cortex_m" else Small([], []),
    )


def _small(plan: Plan, files: dict[str, str]) -> Small:
    """Tasks that seldom run: their speed does not matter, and most of the code is theirs."""
    rates = Rates(plan.graph)
    periods = {task.node.name: rates.node(task.node.name) for task in plan.tasks}
    slow = [task for task in plan.tasks if (periods[task.node.name] or 0) > LONGEST_FAST_US]
    names = {_library_of(plan, task) for task in slow}
    names -= {_library_of(plan, task) for task in plan.tasks if task not in slow}
    sources = (f"tasks/{task.node.name}.cpp" for task in slow)
    return Small(sorted(names), [source for source in sources if source in files])


def _library_of(plan: Plan, task: Task) -> str:
    device = task.node.device
    name = task.node.interface.name if device is None else plan.board.devices[device].driver
    return name.replace("/", "_")


def apps_build(apps: list[Interface], inputs: list[Path]) -> BuildRow:
    """Apps for their unit tests: no graph, no board."""
    nodes = {app.name: app for app in apps}
    texts = list(map(str, inputs))
    return BuildRow("virtual", "", "", [], _libraries(nodes), _roots(nodes), texts, Small([], []))


def _libraries(nodes: dict[str, Interface]) -> list[CMakeLibrary]:
    return [
        CMakeLibrary(
            name=name.replace("/", "_"),
            ports=interface.name,
            folder=str(interface.file.parents[1] / name),
        )
        for name, interface in sorted(nodes.items())
    ]


def _roots(nodes: dict[str, Interface]) -> list[str]:
    return list(dict.fromkeys(str(node.file.parents[2]) for node in nodes.values()))
