"""Which tests a command runs, and the programs that it builds for them."""

import json
import re
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

# Suites and tests as GoogleTest declares them: TEST(Suite, name), TEST_F, TEST_P, TYPED_TEST.
TEST = re.compile(r"^\s*(?:TYPED_)?TEST(?:_[FP])?\(\s*(\w+)\s*,\s*(\w+)", re.MULTILINE)
# A NAME that pytest -k can read; other characters make a regular expression for ctest only.
# `and`, `or` and `not` are its operators.
KEYWORD = re.compile(r"(?!(?:and|or|not)$)[\w:+\-./\[\]]+")
NOT_BUILT = "_NOT_BUILT$"  # what CMake lists in place of the tests of a program that is not built


@dataclass(frozen=True)
class Selection:
    """The tests to run: ctest with this regular expression (empty: not at all), and pytest once
    with each of these lists of arguments. `sources`: the C++ files of tests that it matches."""

    ctest_regex: str
    pytest_runs: list[list[str]]
    sources: list[Path] = field(default_factory=list)


EVERYTHING = Selection(".", [[]])


def select(root: Path, names: list[str]) -> Selection:
    """Splits NAMEs into paths under tests/, and parts of a test's name."""
    if not names:
        return EVERYTHING
    paths = {name: path for name in names if (path := _path_of_tests(root, name))}
    words = [name for name in names if name not in paths]
    named = {file: None for path in paths.values() for file in _cpp_files(path)}
    suites = dict.fromkeys(suite for file in named for suite, _ in _tests(file))
    files = [
        str(path) + "".join(name.partition("::")[1:])
        for name, path in paths.items()
        if _has_python_tests(path)
    ]
    keywords = [word for word in words if KEYWORD.fullmatch(word)]
    runs = [files, ["-k", " or ".join(keywords)] if keywords else []]
    # In one pair of brackets: ctest takes few of them.
    regex = "|".join([*words, *([f"(^|[./])({'|'.join(suites)})[./]"] if suites else [])])
    sources = [*named, *_matching(root, words)]
    return Selection(regex, [run for run in runs if run], list(dict.fromkeys(sources)))


def targets_of(selection: Selection, folder: Path) -> list[str]:
    """The programs with the selected tests, as targets of the configured build folder."""
    found: dict[str, None] = {}
    wanted = {str(source) for source in selection.sources}
    commands = folder / "compile_commands.json"
    text = commands.read_text(encoding="utf-8") if commands.is_file() else "[]"
    for row in json.loads(text):
        program = re.search(r" -o \S*?CMakeFiles/([^/]+)\.dir/", row["command"])
        if program is not None and row["file"] in wanted:
            found[program[1]] = None
    # What is built is known by the names of its tests, and by their programs.
    command = ["ctest", "--test-dir", str(folder), "-N", "--show-only=json-v1"]
    command += ["--tests-regex", selection.ctest_regex, "--exclude-regex", NOT_BUILT]
    listed = subprocess.run(command, check=False, capture_output=True, text=True)
    for test in json.loads(listed.stdout)["tests"] if listed.returncode == 0 else ():
        programs = [Path(word) for word in test.get("command", ())]
        found.update({p.name: None for p in programs if p.is_relative_to(folder) and not p.suffix})
    return list(found)


def _matching(root: Path, words: list[str]) -> Iterator[Path]:
    for file in _cpp_files(root / "tests") if words else ():
        names = [f"{suite}.{name}" for suite, name in _tests(file)]
        if any(_matches(word, name) for word in words for name in names):
            yield file


def _matches(word: str, name: str) -> bool:
    try:
        return re.search(word, name) is not None
    except re.error:  # an expression of ctest's own
        return False


def _path_of_tests(root: Path, name: str) -> Path | None:
    for folder in (Path.cwd(), root):
        path = (folder / name.partition("::")[0]).resolve()
        if path.exists() and path.is_relative_to(root / "tests"):
            return path
    return None


def _cpp_files(path: Path) -> list[Path]:
    return sorted(path.rglob("*.cpp")) if path.is_dir() else [path] * (path.suffix == ".cpp")


def _tests(file: Path) -> list[tuple[str, str]]:
    return TEST.findall(file.read_text(encoding="utf-8", errors="replace"))


def _has_python_tests(path: Path) -> bool:
    return path.suffix == ".py" or (path.is_dir() and any(path.rglob("test_*.py")))
