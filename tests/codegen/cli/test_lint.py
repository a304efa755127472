"""The project passes each check of `./stator lint`; and each check can fail."""

from pathlib import Path

import pytest

from stator.testing.lint import CHECKS, TIDY_FOLDER, TIDY_PROGRAMS, cpp_files

ROOT = Path(__file__).resolve().parents[3]


def name_of_check(name: str) -> object:
    return pytest.param(name, marks=[pytest.mark.long] if CHECKS[name].long else [])


@pytest.mark.parametrize("name", [name_of_check(name) for name in CHECKS])
def test_project_passes(name: str) -> None:
    problems = CHECKS[name].run(ROOT)
    if problems:
        pytest.fail(f"{problems}\nhint: ./stator lint, or ./stator lint --fix", pytrace=False)


# A file with one fault, for each check, and a part of what is said of it.
FAULTS = {
    "clang-format": ("runtime/a.cpp", "int  a;\n", "would reformat: runtime/a.cpp"),
    "ruff check": ("a.py", "import os\n", "F401"),
    "ruff format": ("a.py", "a=1\n", "a.py"),
    "mypy": ("codegen/stator/a.py", "def f(a): return a\n", "a.py:1: error: "),
    "clang-tidy": ("runtime/a.cpp", "int *a = 0;\n", "modernize-use-nullptr"),
}
DATABASE = """[{"directory": "%s", "file": "runtime/a.cpp", "command": "c++ -c runtime/a.cpp"}]"""


@pytest.fixture
def project(tmp_path: Path) -> Path:
    root = tmp_path / "a b"
    for folder in ("runtime", "codegen/stator"):
        (root / folder).mkdir(parents=True)
    for settings in (".clang-format", ".clang-tidy", "pyproject.toml"):
        (root / settings).symlink_to(ROOT / settings)
    (root / "codegen" / "bootstrap.py").touch()
    for program in TIDY_PROGRAMS:
        (root / TIDY_FOLDER / program).mkdir(parents=True)
        (root / TIDY_FOLDER / program / "compile_commands.json").write_text(DATABASE % root)
    return root


@pytest.mark.parametrize("name", CHECKS)
def test_a_fault_is_found(name: str, project: Path) -> None:
    file, text, said = FAULTS[name]
    (project / file).write_text(text)
    assert said in CHECKS[name].run(project)


def test_clang_tidy_shows_what_stops_cmake(tmp_path: Path) -> None:
    assert "CMake Error" in CHECKS["clang-tidy"].run(tmp_path)


def test_expected_output_of_the_generator_is_not_formatted(tmp_path: Path) -> None:
    for file in ("runtime/a.cpp", "tests/golden/a.cpp", "build/a.cpp", ".venv/a.hpp"):
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / file).touch()
    assert list(cpp_files(tmp_path)) == [tmp_path / "runtime" / "a.cpp"]
