"""Writes the C++ of a plan: one small file for each emitted thing, rewritten only if changed.

Same input, same bytes. The head of a file says from which file and line it comes; the body does
not, so that an inserted comment changes heads only.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import jinja2

from stator import HOME
from stator.diagnostics import Mark, UserError
from stator.emit import bridges, cortex_m, devices, metadata, pthread, recording, rows, vehicles
from stator.emit import parameters as params
from stator.emit import tasks as emit_tasks
from stator.names import snake
from stator.plan.hash import graph_hash
from stator.plan.text import plan_text

if TYPE_CHECKING:
    from stator.emit.tasks import TaskRow
    from stator.graph.model import Interface
    from stator.plan.plan import Plan

MANIFEST = "generated_files.txt"
HOSTS = ("pthread", "virtual")
EXECUTORS = ("cortex_m", *HOSTS)


def emit(plan: Plan, *, record: bool = False) -> dict[str, str]:
    """Every generated file: its path below the output folder, and its text. `record`: the flight is
    recorded for replay."""
    files = _parts(rows.interfaces(plan))
    record = record and recording.is_recordable(plan)
    graph = _start(plan.graph.file)
    recorded = recording.task_rows(plan) if record else {}
    tasks = [emit_tasks.task(plan, task, recorded.get(task.node.name)) for task in plan.tasks]
    parameters = params.start_values(plan)
    topics = [rows.topic(plan, topic) for topic in plan.topics.values()]
    files["topics.hpp"] = _render("topics.hpp.j2", graph, topics=topics)
    files["topics.cpp"] = _render("topics.cpp.j2", graph, topics=topics)
    files["tasks.hpp"] = _render("tasks.hpp.j2", graph, tasks=tasks)
    for task in tasks:
        files[f"tasks/{task.name}.cpp"] = _render("task.cpp.j2", task.mark, task=task)
    files["parameters.cpp"] = _render(
        "parameters.cpp.j2",
        graph,
        nodes=parameters,
        recorded=recorded,
        hosted=plan.board.executor in HOSTS,
    )
    table = params.table(plan)
    if table is not None:
        files["parameter_table.cpp"] = _render("parameter_table.cpp.j2", graph, table=table)
    if metadata.is_read(plan):
        files["metadata.cpp"] = _render("metadata.cpp.j2", graph, files=metadata.files(plan))
    if plan.graph.modes is not None:
        files["modes.cpp"] = _render("modes.cpp.j2", graph, modes=rows.modes(plan), recorded=record)
    if any(task.reads_graph for task in tasks):
        observed = rows.observed(plan)
        files["graph_table.cpp"] = _render(
            "graph_table.cpp.j2", graph, tasks=tasks, topics=observed
        )
    log = rows.log(plan)
    if log is not None:
        files["log_table.cpp"] = _render(
            "log_table.cpp.j2",
            graph,
            log=log,
            params=table,
            graph=plan.graph.name,
            hash=graph_hash(plan),
            recording=record,
            hosted=plan.board.executor in HOSTS,
        )
    if record:
        row = recording.recording_row(plan, _shown(plan.graph.file))
        files["recording.hpp"] = _render("recording.hpp.j2", graph, recording=row)
        files["recording.cpp"] = _render("recording.cpp.j2", graph, recording=row)
    if plan.board.executor == "cortex_m":
        files |= _cortex_m(plan, tasks)
    elif plan.board.executor == "pthread":
        files |= _pthread(plan, tasks, topics)
    elif plan.board.executor in EXECUTORS:
        files["executor.cpp"] = _render(
            f"executor_{plan.board.executor}.cpp.j2", graph, tasks=tasks, program=rows.program(plan)
        )
    files |= _devices(plan) | _bridges(plan)
    files["plan.txt"] = plan_text(plan)
    files["graph.cmake"] = _render("graph.cmake.j2", graph, build=rows.build(plan, files))
    return files


def emit_replay(plan: Plan) -> dict[str, str]:
    """The files of the program that replays recordings of this graph, on any machine."""
    files = _parts(rows.interfaces(plan))
    graph = _start(plan.graph.file)
    recorded = recording.task_rows(plan)
    tasks = [emit_tasks.task(plan, task, recorded[task.node.name]) for task in plan.tasks]
    tasks = [task for task in tasks if task.is_replayed]
    topics = [
        {"name": topic.name, "floats": rows.log_floats(topic.message)}
        for topic in plan.topics.values()
    ]
    parameters = params.start_values(plan)
    table = params.table(plan)
    if table is not None:
        table = replace(table, topics=[])  # a recording holds samples as bytes
        files["parameter_table.cpp"] = _render("parameter_table.cpp.j2", graph, table=table)
    if metadata.is_read(plan):
        files["metadata.cpp"] = _render("metadata.cpp.j2", graph, files=metadata.files(plan))
    files |= _bridges(plan)
    files["replay_tasks.hpp"] = _render("replay_tasks.hpp.j2", graph, tasks=tasks)
    for task in tasks:
        files[f"tasks/{task.name}.cpp"] = _render("replay_task.cpp.j2", task.mark, task=task)
    files["replay.cpp"] = _render(
        "replay.cpp.j2", graph, tasks=tasks, topics=topics, parameters=parameters
    )
    files["graph.cmake"] = _render("graph.cmake.j2", graph, build=rows.replay_build(plan, files))
    return files


def emit_apps(apps: list[Interface], inputs: list[Path]) -> dict[str, str]:
    """What unit tests of these apps need. `inputs`: the files that it is made of."""
    files = _parts(apps)
    build = rows.apps_build(apps, inputs)
    files["graph.cmake"] = _render("graph.cmake.j2", _start(apps[0].file), build=build)
    return files


def _parts(interfaces: list[Interface]) -> dict[str, str]:
    """What nodes see: messages and ports."""
    files: dict[str, str] = {}
    for message in rows.messages(interfaces):
        files[f"include/messages/{message.header}.hpp"] = _render(
            "message.hpp.j2",
            message.mark,
            message=message,
            fields=rows.fields(message, rows.defaults(interfaces, message)),
        )
    for interface in interfaces:
        folder = f"ports/{interface.name}"
        files[f"{folder}/{interface.name}_ports.hpp"] = _render(
            "ports.hpp.j2", _start(interface.file), interface=interface, ports=rows.ports(interface)
        )
        if interface.failsafe is not None:
            files[f"{folder}/failsafe_table.hpp"] = _render(
                "failsafe_table.hpp.j2",
                _start(interface.failsafe.file),
                failsafe=rows.failsafe(interface, interface.failsafe),
            )
    return files


def _devices(plan: Plan) -> dict[str, str]:
    """What the board's code and the nodes meet at; and what the simulated world feeds, if any."""
    origin = _start(plan.board.file)
    row = devices.devices(plan.board)
    names = ["devices.hpp", "devices.cpp"] if row.devices else ["devices.hpp"]
    files = {name: _render(f"{name}.j2", origin, board=row) for name in names}
    fed = devices.sensors(plan.board)
    if not fed.devices:
        return files
    names = ["samples.hpp", "sensors.hpp", "hand_over.hpp"]
    files |= {name: _render(f"{name}.j2", origin, board=fed) for name in names}
    vehicle = plan.graph.vehicle
    lines = vehicles.world_lines(vehicle)
    name = "world_vehicle.hpp"
    return files | {name: _render(f"{name}.j2", _start(vehicle.file), lines=lines)}


def _bridges(plan: Plan) -> dict[str, str]:
    """The nodes between machines, and what a board has of the links."""
    files = {}
    for node in plan.graph.nodes.values():
        if node.interface.bridge is not None:
            row = bridges.bridge(plan, node)
            template = f"bridge_{row.kind}.hpp.j2"
            files[row.file] = _render(template, node.mark, bridge=row)
    if plan.graph.wires:
        links = bridges.links(plan)
        files["links.hpp"] = _render("links.hpp.j2", _start(plan.graph.file), links=links)
    return files


def _cortex_m(plan: Plan, tasks: list[TaskRow]) -> dict[str, str]:
    """What bare metal needs besides: the vector table, lines as bits, the linker script."""
    graph, board = _start(plan.graph.file), _start(plan.board.file)
    program = cortex_m.program(plan)
    return {
        "executor.cpp": _render("executor_cortex_m.cpp.j2", graph, tasks=tasks, program=program),
        "lines.hpp": _render("lines.hpp.j2", board, lines=cortex_m.lines(plan)),
        "image.ld": _render("image.ld.j2", board, **cortex_m.image(plan)),
    }


def _pthread(plan: Plan, tasks: list[TaskRow], topics: list[rows.TopicRow]) -> dict[str, str]:
    """Threads share topics in another way, with other slots."""
    graph = _start(plan.graph.file)
    program = pthread.program(plan)
    topics = [
        replace(
            row,
            depth=pthread.depth(plan, plan.topics[row.name]),
            slots=pthread.slots(plan, plan.topics[row.name]),
        )
        for row in topics
    ]
    return {
        "topics.hpp": _render("topics_pthread.hpp.j2", graph, topics=topics),
        "topics.cpp": _render("topics_pthread.cpp.j2", graph, topics=topics),
        "executor.cpp": _render("executor_pthread.cpp.j2", graph, tasks=tasks, program=program),
    }


def write(files: dict[str, str], folder: Path) -> int:
    """Writes changed files, and removes files that only an earlier run wrote. Returns the number of
    changed files. Raises `UserError` if it cannot write, or would overwrite other files.
    """
    try:
        return _write(files, folder)
    except OSError as error:
        raise UserError(
            f"error: cannot write '{error.filename or folder}': {error.strerror}\n"
            "hint: use a folder that is new, empty, or an earlier output"
        ) from error


def _write(files: dict[str, str], folder: Path) -> int:
    manifest = folder / MANIFEST
    if not manifest.is_file() and folder.is_dir() and any(folder.iterdir()):
        raise UserError(
            f"error: expected a new or empty folder, found '{folder}' with other files\n"
            "hint: use a folder that is new, empty, or an earlier output"
        )
    old = manifest.read_bytes().decode(errors="replace").split("\n") if manifest.is_file() else []
    # The list comes first: the files of an interrupted run count as earlier output, too.
    _write_if_changed(manifest, "\n".join(dict.fromkeys([*files, *filter(None, old)])) + "\n")
    changed = 0
    for name in old:
        stale = folder / name
        is_inside = not Path(name).is_absolute() and ".." not in Path(name).parts
        if name and name not in files and is_inside and stale.is_file():
            stale.unlink()
            changed += 1
    for name, text in files.items():
        changed += _write_if_changed(folder / name, text)
    _write_if_changed(manifest, "\n".join(files) + "\n")
    return changed


def _write_if_changed(path: Path, text: str) -> bool:
    if path.is_file() and path.read_bytes() == text.encode():
        return False
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(text.encode())
    return True


def _start(file: Path) -> Mark:
    return Mark(file, 1, 1)


def _shown(file: Path) -> str:
    """A path that is the same on every machine."""
    return str(file.relative_to(HOME)) if file.is_relative_to(HOME) else file.name


def _render(template: str, origin: Mark, **values: Any) -> str:
    text = f"Generated by stator from {_shown(origin.file)}:{origin.line}. Do not edit."
    kind = template.split(".")[-2]
    head = {"cmake": f"# {text}\n", "ld": f"/* {text} */\n"}.get(kind, f"// {text}\n")
    return head + _environment().get_template(template).render(**values)


_cached: list[jinja2.Environment] = []


def _environment() -> jinja2.Environment:
    if not _cached:
        _cached.append(
            jinja2.Environment(
                loader=jinja2.FileSystemLoader(Path(__file__).parent / "templates"),
                undefined=jinja2.StrictUndefined,
                autoescape=False,
                trim_blocks=True,
                lstrip_blocks=True,
                keep_trailing_newline=True,
            )
        )
        _cached[0].filters.update(wrapped=rows.wrapped, snake=snake)
    return _cached[0]
