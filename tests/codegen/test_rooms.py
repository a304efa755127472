"""The rooms of the Python package: each imports only rooms that stand before it."""

import ast
from collections.abc import Iterator
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2] / "codegen" / "stator"
# From the ground up. Modules of the ground are not in a room, and may import each other without a
# circle, as modules of one room may.
GROUND = (
    *("", "rules", "diagnostics", "names", "macros", "quantities", "collector", "arguments"),
    *("version", "lock", "processes"),
)
ROOMS = (
    *(
        "language",
        "graph",
        "plan",
        "machines",
        "prove",
        "emit",
        "pipeline",
        "image",
        "build",
        "review",
        "mission",
        "live",
        "params",
    ),
    *(
        "flight",
        "campaign",
        "charts",
        "convert",
        "view",
        "score",
        "emulator",
        "bench",
        "schema",
        "testing",
        "commands",
    ),
    "__main__",
)
RANK = dict.fromkeys(GROUND, 0) | {name: i for i, name in enumerate(ROOMS, 1)}


def modules() -> dict[str, Path]:
    """Name below stator -> file; a package is its folder's name."""
    found = {}
    for file in sorted(PACKAGE.rglob("*.py")):
        parts = file.relative_to(PACKAGE).with_suffix("").parts
        found[".".join(part for part in parts if part != "__init__")] = file
    return found


def imports(file: Path, known: dict[str, Path]) -> Iterator[str]:
    """Modules of the package that a file imports anywhere in it."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}: a relative import"
            inner = [f"{node.module}.{alias.name}" for alias in node.names]
            names = [n if n.removeprefix("stator.") in known else str(node.module) for n in inner]
        else:
            continue
        for name in names:
            if name == "stator" or name.startswith("stator."):
                yield name.removeprefix("stator").removeprefix(".")


def room_of(module: str) -> str:
    return module.partition(".")[0]


def test_each_module_is_in_a_room_that_has_a_rank() -> None:
    assert {room_of(module) for module in modules()} == set(RANK)


def test_no_import_goes_up() -> None:
    known = modules()
    wrong = [
        f"{module} imports {other}"
        for module, file in known.items()
        for other in imports(file, known)
        if (room_of(other) != room_of(module) and RANK[room_of(other)] >= RANK[room_of(module)] > 0)
        or (RANK[room_of(module)] == 0 and RANK[room_of(other)] > 0)
    ]
    assert wrong == []


def test_no_command_imports_another() -> None:
    known = modules()
    wrong = [
        f"{module} imports {other}"
        for module, file in known.items()
        if module.startswith("commands.")
        for other in imports(file, known)
        if room_of(other) == "commands"
    ]
    assert wrong == []


def test_there_is_no_circle() -> None:
    known = modules()
    needs = {module: set(imports(file, known)) - {module} for module, file in known.items()}
    while free := [module for module, others in needs.items() if not others & needs.keys()]:
        for module in free:
            del needs[module]
    assert needs == {}


def test_the_table_has_each_command() -> None:
    from stator.__main__ import COMMANDS

    files = {module.partition(".")[2] for module in modules() if module.startswith("commands.")}
    assert {command.name for command in COMMANDS} - {"setup"} == files


def test_only_the_table_imports_by_name() -> None:
    hidden = ("import_module", "__import__")
    files = {m for m, file in modules().items() if any(h in file.read_text() for h in hidden)}
    assert files == {"__main__"}
