"""`./stator new`: writes the files of a new app, graph or vehicle, ready to build and to change."""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import TYPE_CHECKING

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from stator import HOME
from stator.arguments import path
from stator.diagnostics import Report, UserError, in_place, nearest, shown_argument, shown_path
from stator.graph.sources import Sources
from stator.language.shapes import NAME_HINT, NAME_PATTERN
from stator.names import reserved_reason, reserved_type_reason, upper_camel

if TYPE_CHECKING:
    from collections.abc import Mapping

TEMPLATES = Path(__file__).parent / "new_templates"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    kinds = parser.add_subparsers(dest="kind", metavar="app|graph|vehicle", required=True)
    app = kinds.add_parser("app", help="a node: interface, code, and a message to publish")
    graph = kinds.add_parser("graph", help="a vehicle that differs from the quadrotor")
    graph.add_argument("--app", help="add a node of this app, which `./stator new app` has written")
    graph.add_argument("--vehicle", help="the vehicle that flies it (default: the Iris)")
    vehicle = kinds.add_parser("vehicle", help="mass, rotors, battery: a vehicle of one's own")
    vehicle.add_argument(
        "--like", default="iris", help="the vehicle to copy and to change (default: iris)"
    )
    for kind in (app, graph, vehicle):
        kind.add_argument("name", help="name in snake_case, for example tilt_watch")
        kind.add_argument(
            "--in",
            dest="folder",
            type=path,
            default=Path(),
            metavar="DIR",
            help="folder of apps/ and graphs (default: the current folder)",
        )


def main(arguments: argparse.Namespace) -> int:
    name: str = arguments.name
    _check_name(name, "an app" if arguments.kind == "app" else "")
    if arguments.kind == "app":
        files = _app(name, arguments.folder)
        following = f"./stator new graph {name}_quad --app {name}"
        if arguments.folder != Path():
            following += f" --in {shown_argument(arguments.folder)}"
        tests = arguments.folder / "tests" / "apps" / name
        following += f"\ntest: ./stator test {shown_argument(tests)}"
    elif arguments.kind == "vehicle":
        files = _vehicle(name, arguments.folder, arguments.like)
        following = f"./stator check {shown_argument(next(iter(files)))}"
        following += f"\nfly: write `vehicle: {name}` in a graph"
    else:
        if arguments.app is not None:
            _check_name(arguments.app, "an app")
        files = _graph(name, arguments.folder, arguments.app, arguments.vehicle)
        following = f"./stator fly {shown_argument(next(iter(files)))}"
    _write(files)
    print("\n".join(f"{shown_path(file)}: written" for file in files))
    print(in_place(f"next: {following}"))
    return 0


def _check_name(name: str, what: str) -> None:
    """Raises `UserError` for a name that the compiler would refuse."""
    if not re.fullmatch(NAME_PATTERN, name):
        raise UserError(f"error: expected a name, found '{name}'\nhint: {NAME_HINT}")
    reason = reserved_reason(name, what) or (what and reserved_type_reason(upper_camel(name)))
    if reason:
        raise UserError(
            f"error: '{name}' cannot be a name: {reason}"
            "\nhint: choose another name, for example tilt_watch"
        )


def _app(name: str, folder: Path) -> dict[Path, str]:
    fields = {"name": name, "class": upper_camel(name), "message": f"{upper_camel(name)}Report"}
    messages = folder / ("graph/messages" if folder.resolve() == HOME else "messages")
    app = folder / "apps" / name
    existing = HOME / "apps" / name
    if existing.is_dir() and app.resolve() != existing:
        raise UserError(
            f"error: duplicate app '{name}': Stator has an app of this name\n"
            f"hint: choose another name; to change that app, copy {shown_path(existing)} to apps"
        )
    return {
        messages / f"{fields['message']}.yaml": _render("message.yaml.j2", fields),
        app / f"{name}.yaml": _render("app.yaml.j2", fields),
        app / f"{name}.hpp": _render("app.hpp.j2", fields),
        app / f"{name}.cpp": _render("app.cpp.j2", fields),
        folder / "tests" / "apps" / name / f"{name}_test.cpp": _render("test.cpp.j2", fields),
    }


def _vehicle(name: str, folder: Path, like: str) -> dict[Path, str]:
    vehicles = _graphs(folder) / "vehicles"
    return {vehicles / f"{name}.yaml": _vehicle_file(folder, like).read_text(encoding="utf-8")}


def _vehicle_file(folder: Path, name: str) -> Path:
    known = Sources(folder, Report()).vehicles()
    if name not in known:
        raise UserError(f"error: unknown vehicle '{name}'\nhint: {nearest(name, known)}")
    return known[name]


def _graphs(folder: Path) -> Path:
    return folder / "graph" if folder.resolve() == HOME else folder


def _graph(name: str, folder: Path, app: str | None, vehicle: str | None) -> dict[Path, str]:
    if vehicle is not None:
        _vehicle_file(folder, vehicle)
    if app is not None and not (folder / "apps" / app / f"{app}.yaml").is_file():
        raise UserError(
            f"error: unknown app '{app}' in {shown_path(folder / 'apps')}\n"
            f"hint: ./stator new app {app}"
        )
    fields = {"name": name, "app": app, "vehicle": vehicle}
    return {_graphs(folder) / f"{name}.yaml": _render("graph.yaml.j2", fields)}


def _render(template: str, fields: Mapping[str, str | None]) -> str:
    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),
        undefined=StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
    )
    return environment.get_template(template).render(fields)


def _write(files: Mapping[Path, str]) -> None:
    """Writes all files or none. Raises `UserError` instead of replacing a file."""
    for file in files:
        if file.exists():
            raise UserError(
                f"error: {shown_path(file)} exists already; nothing was written\n"
                "hint: choose another name, or remove the file"
            )
    try:
        for file, text in files.items():
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
    except OSError as error:
        for written in files:
            written.unlink(missing_ok=True)
        raise UserError(f"error: cannot write '{shown_path(file)}': {error.strerror}") from None
