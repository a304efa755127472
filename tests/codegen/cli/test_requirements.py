"""The list of Python packages: pinned, complete, and what this environment has."""

import re
from importlib.metadata import distribution
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[3]


def pinned_packages() -> dict[str, str]:
    lines = (ROOT / "requirements.txt").read_text().splitlines()
    requirements = [line.partition("#")[0].strip() for line in lines]
    pairs = [line.split("==") for line in requirements if line]
    return {canonicalize_name(name): version for name, version in pairs}


def test_this_environment_has_the_pinned_versions() -> None:
    pinned = pinned_packages()
    assert {name: distribution(name).version for name in pinned} == pinned


def test_what_the_packages_need_is_pinned_too() -> None:
    pinned = pinned_packages()
    needed = {
        canonicalize_name(requirement.name)
        for name in pinned
        for requirement in map(Requirement, distribution(name).requires or [])
        if requirement.marker is None or requirement.marker.evaluate({"extra": ""})
    }
    assert needed <= set(pinned)


def test_each_debian_package_has_a_sign() -> None:
    lines = (ROOT / "requirements-apt.txt").read_text().splitlines()
    packages = [line for line in lines if not line.startswith("#")]
    assert packages
    assert all(re.fullmatch(r"[a-z0-9+.-]+ +\S+", line) for line in packages)
