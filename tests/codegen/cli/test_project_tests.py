"""`./stator test` in a folder outside the repository: tests of one's own nodes and graphs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from stator import __main__ as cli

if TYPE_CHECKING:
    from pathlib import Path

GRAPH_TEST = """
#include <gtest/gtest.h>

#include "flight_of_graph.hpp"

TEST(LeanQuad, hovers_and_reports_nothing) {
    stator::testing::FlightOfGraph flight;
    flight.run_for(10'000'000);  // us
    EXPECT_TRUE(flight.newest<stator::VehicleAttitude>(stator::topics::vehicle_attitude));
    EXPECT_FALSE(flight.newest<stator::LeanReport>(stator::topics::lean));
    EXPECT_NEAR(flight.world().plant().state().position_N.z(), -2.0, 0.2);
}
"""


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    root = tmp_path / "my nodes"
    root.mkdir()
    monkeypatch.chdir(root)
    assert cli.main(["new", "app", "lean"]) == 0
    return root


def test_the_test_that_new_app_writes_passes_and_can_fail(
    project: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert cli.main(["test"]) == 0
    assert capfd.readouterr().out.splitlines()[-1] == "2 passed, 0 failed, 0 skipped"

    test = project / "tests" / "apps" / "lean" / "lean_test.cpp"
    test.write_text(test.read_text().replace("1.5708F", "1.7F"))
    monkeypatch.chdir(project / "apps" / "lean")
    assert cli.main(["test"]) == 1
    out = capfd.readouterr().out
    assert "lean_test.cpp:20: Failure" in out
    assert out.splitlines()[-1] == "1 passed, 1 failed, 0 skipped"

    assert cli.main(["test", "says_nothing"]) == 0
    assert capfd.readouterr().out.splitlines()[-1] == "1 passed, 0 failed, 0 skipped"
    assert cli.main(["test", str(test)]) == 1

    monkeypatch.chdir(project)  # one more app, of which only this is built
    assert cli.main(["new", "app", "tilted"]) == 0
    assert cli.main(["test", "tests/apps/tilted"]) == 0
    assert capfd.readouterr().out.splitlines()[-1] == "2 passed, 0 failed, 0 skipped"


def test_a_graph_flies_in_a_test(project: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["new", "graph", "lean_quad", "--app", "lean"]) == 0
    test = project / "tests" / "graphs" / "lean_quad" / "lean_quad_test.cpp"
    test.parent.mkdir(parents=True)
    test.write_text(GRAPH_TEST)
    assert cli.main(["test", "tests/graphs"]) == 0
    assert capfd.readouterr().out.splitlines()[-1] == "1 passed, 0 failed, 0 skipped"


def test_code_that_does_not_compile_is_a_failed_test(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    code = project / "apps" / "lean" / "lean.cpp"
    code.write_text(code.read_text().replace("const float tilt", "const float slope"))
    assert cli.main(["test"]) == 1
    out = capfd.readouterr().out
    assert "apps/lean/lean.cpp:10:" in out
    assert out.splitlines()[-1] == "0 passed, 1 failed, 0 skipped"


def test_an_error_in_an_interface_is_named(
    project: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    interface = project / "apps" / "lean" / "lean.yaml"
    interface.write_text(interface.read_text().replace("VehicleAttitude", "VehicleAtitude"))
    assert cli.main(["test"]) == 2
    assert "lean.yaml:3:23: error: unknown message 'VehicleAtitude'" in capfd.readouterr().err


def test_a_folder_without_tests_or_apps_is_no_project(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cli.main(["test"]) == 2
    assert (
        "error: expected a project with apps/ or tests/, found none in" in capsys.readouterr().err
    )
