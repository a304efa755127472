"""Generated codecs and the package `dronecan` read the same values out of any bytes."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from dronecan.dsdl.parser import PrimitiveType
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

ROOT = Path(__file__).resolve().parents[3]
HERE = Path(__file__).parent
sys.path[:0] = [str(ROOT / "codegen"), str(HERE)]

from dronecan_values import limits, make, modes, pack, renewed, service_or_message, single, unpack  # noqa: E402
from tests.host_program import host_program  # noqa: E402

from stator.build.dronecan_codecs import TYPES  # noqa: E402

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

KINDS = [(name, mode) for name in TYPES for mode in modes(service_or_message(name))]
SETTINGS = settings(
    max_examples=60,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)


@pytest.fixture(scope="module")
def echo() -> Iterator[Callable[[Any, str | None, bytes], bytes | None]]:
    program = host_program("tests/runtime/dronecan/codec_echo")
    with subprocess.Popen([program], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdin and process.stdout

        def ask(kind: Any, mode: str | None, payload: bytes) -> bytes | None:
            assert process.stdin and process.stdout
            number = [None, "request", "response"].index(mode)
            process.stdin.write(f"{number} {kind.default_dtid} {payload.hex()}\n".encode())
            process.stdin.flush()
            answer = process.stdout.readline().decode().strip()
            return None if answer == "bad" else bytes.fromhex(answer)

        yield ask
        process.stdin.close()


def primitive(data: st.DataObject, kind: Any) -> Any:
    if kind.kind == PrimitiveType.KIND_BOOLEAN:
        return data.draw(st.booleans())
    least, most = kind.value_range
    if kind.kind == PrimitiveType.KIND_FLOAT:
        number = st.floats(width=32, allow_nan=False)
        return data.draw(st.one_of(number, st.sampled_from(limits(kind)).map(_narrow)))
    return data.draw(st.integers(least, most))


def _narrow(value: float) -> float:
    return value if math.isinf(value) else single(value)


@pytest.mark.parametrize(("name", "mode"), KINDS)
@SETTINGS
@given(data=st.data())
def test_values_survive(
    name: str,
    mode: str | None,
    data: st.DataObject,
    echo: Callable[[Any, str | None, bytes], bytes | None],
) -> None:
    kind = service_or_message(name)
    value = make(
        kind,
        mode,
        lambda of: primitive(data, of),
        lambda most: data.draw(st.integers(0, most)),
        lambda count: data.draw(st.integers(0, count - 1)),
    )
    payload = pack(value)
    assert echo(kind, mode, payload) == payload


@pytest.mark.parametrize(("name", "mode"), KINDS)
@SETTINGS
@given(payload=st.binary(max_size=380))
def test_any_bytes_are_read_alike_or_refused(
    name: str,
    mode: str | None,
    payload: bytes,
    echo: Callable[[Any, str | None, bytes], bytes | None],
) -> None:
    kind = service_or_message(name)
    answer = echo(kind, mode, payload)
    if answer is not None:
        assert answer == pack(renewed(unpack(kind, mode, payload)))


def test_the_vectors_are_what_the_recipe_makes() -> None:
    recipe = [sys.executable, str(HERE / "make_vectors.py")]
    made = subprocess.run(recipe, capture_output=True, text=True, check=True).stdout
    assert made == (HERE / "vectors.inc").read_text(encoding="utf-8")
