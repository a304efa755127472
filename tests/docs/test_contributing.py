"""The recipes of CONTRIBUTING.md, followed to the letter in a copy of the project; and the files
that editors, commits, containers and forges read."""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from stator import HOME

COPIED = ("apps", "boards", "codegen", "docs", "drivers", "graph", "runtime", "tests")
# ```LANGUAGE FILE, the content, ```
BLOCK = re.compile(r"^```(\w+)(?: (\S+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)
# In place of ./stator: the copy's own command line. `test` runs only the Python tests; those of
# C++ would build everything.
STATOR = """#!/usr/bin/env bash
set -euo pipefail
export PYTHONPATH={root}/codegen
if [[ $1 != test ]]; then exec {python} -X utf8 -m stator "$@"; fi
shift
python_tests=()
for path; do
    [[ -e ${{path%%::*}} ]] || {{ echo "no tests: $path" >&2; exit 2; }}
    [[ $path != *.py* && -z $(find "$path" -name 'test_*.py') ]] || python_tests+=("$path")
done
((${{#python_tests[@]}})) || exit 0
exec {python} -X utf8 -m pytest -q -p no:cacheprovider "${{python_tests[@]}}"
"""


def sections() -> dict[str, str]:
    """Heading of a recipe -> its text."""
    text = (HOME / "CONTRIBUTING.md").read_text(encoding="utf-8")
    heads = re.split(r"^## (.+)\n", text, flags=re.MULTILINE)[1:]
    found = dict(zip(heads[::2], heads[1::2], strict=True))
    del found["The ten-minute changes"]
    return found


def promised_files() -> dict[str, int]:
    """The table: recipe -> number of files."""
    text = (HOME / "CONTRIBUTING.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| \[(.+)\]\(#[a-z-]+\) \| (\d+) \|$", text, re.MULTILINE)
    return {name: int(count) for name, count in rows}


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A copy of the project, with its own command line."""
    root = tmp_path / "a b"
    for folder in COPIED:
        shutil.copytree(
            HOME / folder,
            root / folder,
            symlinks=True,
            ignore=shutil.ignore_patterns("__pycache__"),
        )
    for file in HOME.iterdir():
        if file.is_file():
            shutil.copy(file, root)
    script = STATOR.format(root=shlex.quote(str(root)), python=shlex.quote(sys.executable))
    (root / "stator").write_text(script, encoding="utf-8")
    return root


def content(root: Path) -> dict[str, bytes]:
    """The files that a commit would have."""
    return {
        str(file.relative_to(root)): file.read_bytes()
        for folder in COPIED
        for file in (root / folder).rglob("*")
        if file.is_file() and file.suffix != ".pyc"
    }


def change(file: Path, lines: list[str]) -> None:
    """Applies a block with `+` and `-`; its other lines say where. They occur once."""
    before = "".join(line[1:] + "\n" for line in lines if line[0] in " -")
    after = "".join(line[1:] + "\n" for line in lines if line[0] in " +")
    text = file.read_text(encoding="utf-8")
    assert f"\n{text}".count(f"\n{before}") == 1, f"{file}: expected once:\n{before}"
    file.write_text(f"\n{text}".replace(f"\n{before}", f"\n{after}")[1:], encoding="utf-8")


def add_column(file: Path, event: str) -> None:
    """What step 2 of "A failsafe event" says in words."""
    parts = re.split(r"(\n(?:table|landed):.*\n)", file.read_text(encoding="utf-8"))
    for i in (2, 4):  # in the air, and on the ground
        rows = [line.removesuffix("]") for line in parts[i].splitlines()]
        assert rows[0].startswith("  event:")
        width = max(map(len, rows)) + 1
        cells = [event] + ["go_on"] * (len(rows) - 1)
        lines = zip(rows, cells, strict=True)
        parts[i] = "".join(f"{f'{row},':{width}} {cell}]\n" for row, cell in lines)
    file.write_text("".join(parts), encoding="utf-8")


def follow(recipe: str, root: Path) -> None:
    for language, name, text in BLOCK.findall(sections()[recipe]):
        if language == "sh":
            run(text, root)
        elif language == "diff":
            change(root / name, text.splitlines())
            if name.endswith("failsafe.yaml"):
                add_column(root / name, "log_lost")
        else:
            assert not (root / name).exists()
            (root / name).write_text(text, encoding="utf-8")


def run(commands: str, root: Path) -> None:
    (root / "stator").chmod(0o755)
    finished = subprocess.run(
        ["bash", "-euc", commands],
        cwd=root,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    assert finished.returncode == 0, f"{commands}\n{finished.stdout}"


def compile_app(app: str, graph: str, root: Path) -> None:
    """Only as far as its errors, with what is generated for it."""
    run(f"./stator gen graph/{graph}.yaml --board sitl -o build/{graph}", root)
    generated = root / "build" / graph
    folders = [generated / "include", generated / "ports" / app]
    folders += [file.parent for file in root.glob("runtime/*/stator")]
    command = ["g++", "-std=c++20", "-fsyntax-only", "-isystem", "/usr/include/eigen3"]
    command += [f"-I{folder}" for folder in folders]
    run(shlex.join([*command, f"apps/{app}/{app}.cpp"]), root)


def test_the_table_lists_each_recipe() -> None:
    assert list(promised_files()) == list(sections())


@pytest.mark.parametrize("recipe", sections())
def test_a_recipe_works_and_touches_so_many_files(recipe: str, project: Path) -> None:
    before = content(project)
    follow(recipe, project)
    after = content(project)
    changed = sorted(name for name, data in after.items() if before.get(name) != data)
    assert len(changed) == promised_files()[recipe], changed
    if "apps/commander/commander.cpp" in changed:
        compile_app("commander", "quad_outdoor", project)
    python = [name for name in changed if name.endswith(".py")]
    for check in (["check"], ["format", "--check"]):
        command = [sys.executable, "-m", "ruff", *check, "--quiet", "--no-cache", *python]
        assert not python or subprocess.run(command, cwd=project, check=False).returncode == 0


def test_a_step_that_no_longer_fits_is_found(tmp_path: Path) -> None:
    file = tmp_path / "a.yaml"
    file.write_text("a: 1\nb: 2\n", encoding="utf-8")
    change(file, [" a: 1", "+c: 3"])
    assert file.read_text(encoding="utf-8") == "a: 1\nc: 3\nb: 2\n"
    with pytest.raises(AssertionError, match="expected once"):
        change(file, ["-d: 1"])
    with pytest.raises(AssertionError, match="no tests: tests/none"):
        shutil.copy(HOME / "CONTRIBUTING.md", tmp_path)
        (tmp_path / "stator").write_text(STATOR.format(root=tmp_path, python=sys.executable))
        run("./stator test tests/none", tmp_path)


# --- files that other programs read ---


def read(name: str) -> str:
    return (HOME / name).read_text(encoding="utf-8")


def test_a_commit_runs_lint() -> None:
    (repository,) = yaml.safe_load(read(".pre-commit-config.yaml"))["repos"]
    (hook,) = repository["hooks"]
    assert (repository["repo"], hook["language"]) == ("local", "system")
    assert hook["entry"] == "./stator lint"
    assert not hook["pass_filenames"]


def test_a_forge_runs_all_tests() -> None:
    steps = yaml.safe_load(read(".github/workflows/test.yml"))["jobs"]["test"]["steps"]
    assert steps[-1] == {"run": ".ci/run"}
    assert os.access(HOME / ".ci" / "run", os.X_OK)


def test_a_container_is_set_up_by_stator() -> None:
    container = json.loads(read(".devcontainer/devcontainer.json"))
    assert container["postCreateCommand"] == "./stator setup"
    dockerfile = read(f".devcontainer/{container['build']['dockerfile']}")
    assert "\nFROM debian:" in dockerfile


def test_editors_and_formatters_agree() -> None:
    settings = read(".editorconfig")
    assert "\nmax_line_length = 100\n" in settings
    assert "\nindent_size = 4\n" in settings
    assert "ColumnLimit: 100\n" in read(".clang-format")
    assert "IndentWidth: 4\n" in read(".clang-format")
    assert "\nline-length = 100\n" in read("pyproject.toml")
