"""Order of the tests: what takes long by itself comes first, and so is not left for the end. No
progress on standard error, which depends on the load of the machine. And names of tests that are
the same in every process that collects them."""

import os

import pytest

os.environ["STATOR_PROGRESS"] = "off"

FIRST = ("flight/can_bus", "drivers/can", "codegen/replay", "flight/", "codegen/image")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    def rank(item: pytest.Item) -> int:
        places = [i for i, folder in enumerate(FIRST) if f"tests/{folder}" in item.path.as_posix()]
        return places[0] if places else len(FIRST)

    items.sort(key=rank)


def pytest_make_parametrize_id(val: object) -> str | None:
    """A parameter of bytes is named by their number. Values may differ between processes (what
    gzip wrote holds the time), and pytest-xdist refuses workers that found other tests."""
    return f"{len(val)} bytes" if isinstance(val, bytes) else None
