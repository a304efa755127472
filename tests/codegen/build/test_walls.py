"""What nodes and boards cannot include, and where they cannot declare: each direction is tried."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from stator import HOME
from stator.build.cmake import build
from stator.build.walls import ROOMS, Node, Walls
from stator.diagnostics import BuildFailed

OWN = """namespace stator::apps::own {
class Own {
  public:
    void step(OwnPorts& ports);
};
}  // namespace stator::apps::own
"""
MOTOR = "namespace stator::drivers::motor::mine {}\n"
# Two apps, two drivers of one class and one of another, and two boards.
FILES = {
    "apps/own/own.hpp": OWN,
    "apps/own/detail/part.hpp": OWN,
    "apps/other/other.hpp": "",
    "drivers/motor/motor_shared.hpp": "namespace stator::drivers::motor {}\n",
    "drivers/motor/mine/motor_mine.hpp": MOTOR,
    "drivers/motor/other/motor_other.hpp": "",
    "drivers/radio/sim/radio_sim.hpp": "",
    "boards/mine/main.cpp": "",
    "boards/mine/board.yaml": "",
    "boards/mine/pins.hpp": "",
    "boards/other/pins.hpp": "",
    "boards/other/board.yaml": "",
    "boards/shared/shared.hpp": "",
    "ports/own/own_ports.hpp": '#include "messages/count.hpp"\n#include "stator/log.hpp"\n',
    "ports/motor/motor_ports.hpp": '#include "messages/count.hpp"\n',
}


@pytest.fixture
def project(tmp_path: Path) -> Path:
    for name, text in FILES.items():
        file = tmp_path / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    return tmp_path


def of_node(project: Path, folder: str, text: str, place: str = "") -> list[str]:
    """The messages for a node whose header begins with this."""
    node = Node(project / folder, project / "ports" / folder.split("/")[1])
    file = project / folder / (place or node.sources[0].name)
    if place:
        node.sources[0].write_text(f'#include "{place}"\n')
    file.write_text(text + file.read_text())
    walls = Walls()
    walls.check_node(node)
    return [error.message for error in walls.errors]


def of_app(project: Path, text: str) -> list[str]:
    return of_node(project, "apps/own", text)


def of_driver(project: Path, text: str) -> list[str]:
    return of_node(project, "drivers/motor/mine", text)


def of_board(project: Path, text: str) -> list[str]:
    (project / "boards/mine/main.cpp").write_text(text)
    walls = Walls()
    walls.check_board(project / "boards/mine")
    return [error.message for error in walls.errors]


EVERY_NODE = (
    '"own_ports.hpp" "messages/count.hpp" <array> <cstdint> <algorithm> <Eigen/Core> '
    '"stator/port.hpp" "stator/scalar.hpp" "stator/rotation.hpp" "stator/crc32.hpp" '
    '"stator/dronecan/receiver.hpp" "dronecan/protocol/node_status.hpp"'
)


def test_an_app_includes_what_is_for_it(project: Path) -> None:
    text = "".join(f"#include {name}\n" for name in [*EVERY_NODE.split(), '"detail/part.hpp"'])
    assert of_app(project, text) == []


def test_a_driver_includes_what_is_for_it(project: Path) -> None:
    names = [*EVERY_NODE.replace("own_ports", "motor_ports").split(), '"../motor_shared.hpp"']
    text = "".join(f"#include {name}\n" for name in [*names, "<unistd.h>", "<cstdio>"])
    assert of_driver(project, text) == []


def test_a_board_includes_what_is_for_it(project: Path) -> None:
    names = ("pins.hpp", "drivers/motor/mine/motor_mine.hpp", "stator/virtual.hpp", "tasks.hpp")
    assert of_board(project, "".join(f'#include "{name}"\n' for name in names)) == []


@pytest.mark.parametrize(
    "name",
    [
        '"../other/other.hpp"',  # an app
        '"apps/other/other.hpp"',
        '"other_ports.hpp"',
        '"../../drivers/radio/sim/radio_sim.hpp"',  # a driver
        '"drivers/radio/sim/radio_sim.hpp"',
        '"../../boards/other/pins.hpp"',  # a board
        '"board.hpp"',
        '"../../boards/shared/shared.hpp"',
        '"world/wind.hpp"',
        '"tasks.hpp"',  # generated glue
        '"topics.hpp"',
        '"recording.hpp"',
        '"devices.hpp"',
        '"messages/mission.hpp"',  # of no port
        "<stator/virtual.hpp>",
        "<../own/own.hpp>",
        "SOMETHING",
    ],
)
def test_an_app_and_a_driver_cannot_include(project: Path, name: str) -> None:
    assert of_app(project, f"#include {name}\n")
    assert of_driver(project, f"#include {name}\n")


def test_a_driver_cannot_include_another(project: Path) -> None:
    for name in ("../other/motor_other.hpp", "../../radio/sim/radio_sim.hpp"):
        assert of_driver(project, f'#include "{name}"\n')


@pytest.mark.parametrize(
    "name", ["../../apps/own/own.hpp", "apps/own/own.hpp", "../other/pins.hpp"]
)
def test_a_board_cannot_include(project: Path, name: str) -> None:
    assert len(of_board(project, f'#include "{name}"\n')) == 1


def test_no_node_includes_another_room_of_the_runtime(project: Path) -> None:
    """Also of a room that is made tomorrow."""
    rooms: dict[str, set[str]] = {}
    for room in (HOME / "runtime").iterdir():
        for file in room.rglob("*.hpp"):
            rooms.setdefault(file.as_posix().rpartition("/stator/")[2], set()).add(room.name)
    wrong = sorted(name for name, found in rooms.items() if not found & set(ROOMS))
    assert "virtual.hpp" in wrong
    for name in wrong:
        file = project / "apps/own/own.hpp"
        file.write_text(OWN)
        assert of_app(project, f'#include "stator/{name}"\n'), name


def test_every_folder_with_code_has_a_wall() -> None:
    """A new folder of the top level needs a row in `room_of`, and its directions above."""
    folders = [f for f in HOME.iterdir() if f.is_dir() and f.name[0] != "." and f.name != "build"]
    found = {folder.name for folder in folders if any(folder.rglob("*.hpp"))}
    assert found == {"apps", "drivers", "boards", "runtime", "tests", "graph"}


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("chrono", "reads a clock"),
        ("ctime", "reads a clock"),
        ("cstdio", "does input or output"),
        ("iostream", "does input or output"),
        ("unistd.h", "does input or output"),
        ("thread", "waits or shares"),
        ("mutex", "waits or shares"),
        ("atomic", "waits or shares"),
        ("vector", "allocates"),
        ("string", "allocates"),
        ("functional", "allocates"),
        ("cmath", "gives other bits on other machines"),
        ("random", "gives other bits on other machines"),
    ],
)
def test_an_app_has_no_clock_no_files_no_heap(project: Path, name: str, why: str) -> None:
    assert of_app(project, f"#include <{name}>\n") == [
        f"an app cannot include <{name}>, which {why}"
    ]


def test_an_unknown_header_is_refused(project: Path) -> None:
    assert of_app(project, "#include <sys/whatever.h>\n")


def test_what_an_included_file_includes_counts(project: Path) -> None:
    assert of_node(project, "apps/own", '#include "../../other/other.hpp"\n', "detail/part.hpp")


@pytest.mark.parametrize(
    "text",
    [
        '  #  include\t"tasks.hpp"',
        '%:include "tasks.hpp"',
        '#include /* here */ "tasks.hpp"',
        '#inc\\\nlude "tasks.hpp"',
        '#if 0\n#else\n#include "tasks.hpp"\n#endif',
        '#include_next "tasks.hpp"',
    ],
)
def test_every_spelling_of_an_include_is_seen(project: Path, text: str) -> None:
    assert of_app(project, f"{text}\n") == [
        "the folder of this app, its ports and the runtime have no header 'tasks.hpp'"
    ]


@pytest.mark.parametrize(
    "text",
    [
        '// #include "tasks.hpp"\n',
        '/* \n#include "tasks.hpp"\n*/',
        'namespace stator::apps::own { const char* t = R"x(\n#include "tasks.hpp"\n)x"; }',
    ],
)
def test_what_is_no_include_is_not(project: Path, text: str) -> None:
    assert of_app(project, f"{text}\n") == []


@pytest.mark.parametrize(
    "text",
    [
        "class Helper { int x; };",
        "namespace stator { struct Helper { int x; }; }",
        "namespace stator::apps { int count; }",
        "namespace stator { inline float twice(float x) { return 2 * x; } }",
        "template <class T> T twice(T x) { return x + x; }",
        "constexpr int kCount = 3;",
        "namespace stator::apps::own {} int count;",
        "namespace stator { using Vector = int; }",
        "enum class State { kOn };",
        'extern "C" void helper() {}',
        'extern "C" { void helper() {} }',
        'namespace stator::apps::own { extern "C" void helper() {} }',
        'namespace stator::apps::own { extern "C" { int count; } }',
        "namespace stator::apps::other { int count; }",
        "namespace stator::apps::own { } }\nint count;",
        "namespace std { template <> struct hash<int> { int x; }; }",
        "#if A\nnamespace A {\n#else\nnamespace stator::apps::own {\n#endif\n}\nint x;",
    ],
)
def test_an_app_declares_in_its_namespace_only(project: Path, text: str) -> None:
    (message,) = of_app(project, f"{text}\n")
    assert message.startswith("expected namespace stator::apps::own, found ")


@pytest.mark.parametrize(
    "text",
    [
        "namespace stator::apps::own { struct A { int x; }; void f() { struct B {}; } }",
        "namespace stator::apps::own { int x = 1'000; }",
        "namespace stator { namespace apps::own { int x; namespace detail { int y; } } }",
        "namespace { int x; }",
        "namespace stator { namespace { int x; } }",
        "namespace stator { struct VehicleStatus; class Other; enum class E : int; }",
        "using namespace stator; namespace own = stator::apps::own; using stator::Input;",
        "static_assert(sizeof(int) == 4);",
        "namespace stator::apps::own { char brace = '{'; const char* t = \"{\"; /* { */ }\n// {",
        "#if A\nnamespace A {\n#else\nnamespace stator::apps::own {\n#endif\nint x;\n}",
        "namespace stator::apps::own { const auto f = [](int a) { return a; }; }",
    ],
)
def test_what_is_in_its_namespace_is_right(project: Path, text: str) -> None:
    assert of_app(project, f"{text}\n") == []


def test_what_a_class_of_drivers_shares_is_in_the_class_namespace(project: Path) -> None:
    shared = project / "drivers/motor/motor_shared.hpp"
    assert of_driver(project, '#include "../motor_shared.hpp"\n') == []
    shared.write_text("namespace stator { int count; }\n")
    assert len(of_driver(project, "")) == 1


def test_it_does_not_build(tmp_path: Path) -> None:
    """The same from the outside: before anything is compiled."""
    examples = Path(shutil.copytree(HOME / "graph" / "examples", tmp_path / "walled"))
    header = examples / "apps" / "counter" / "counter.hpp"
    header.write_text(header.read_text().replace("#include <cstdint>", "#include <chrono>"))
    with pytest.raises(BuildFailed, match=r"counter\.hpp:\d+:1: error: an app cannot include <chr"):
        build(examples / "timer.yaml", None)
    header.write_text(header.read_text().replace("#include <chrono>", "int count = 0;"))
    with pytest.raises(BuildFailed, match=r"counter\.hpp:\d+:1: error: expected namespace stator"):
        build(examples / "timer.yaml", None)


def test_two_apps_may_have_files_of_one_name(tmp_path: Path) -> None:
    """And the names of files of the board and of the world."""
    examples = Path(shutil.copytree(HOME / "graph" / "examples", tmp_path / "twins"))
    for app, count in (("adder", 1), ("counter", 2)):
        folder = examples / "apps" / app
        for name in ("board", "wind", "plant"):
            (folder / f"{name}.hpp").write_text(
                f"#pragma once\nnamespace stator::apps::{app} {{\nstruct Helper {{\n"
                f"    int values[{count}]{{}};\n    int size() const;\n}};\n}}\n"
            )
        (folder / "board.cpp").write_text(
            f'#include "board.hpp"\nnamespace stator::apps::{app} {{\n'
            f"int Helper::size() const {{ return {count}; }}\n}}\n"
        )
        header = folder / f"{app}.hpp"
        header.write_text(
            header.read_text().replace("#pragma once", '#pragma once\n#include "board.hpp"')
        )
    assert build(examples / "topic.yaml", None).is_file()


def of_class(project: Path, code: str) -> list[str]:
    """The errors for an app with this code in its namespace."""
    header = project / "apps" / "own" / "own.hpp"
    header.write_text(f"namespace stator::apps::own {{\n{code}\n}}  // namespace\n")
    walls = Walls()
    walls.check_node(Node(project / "apps" / "own", project / "ports" / "own"))
    return [f"{e.mark.line}:{e.mark.column}: {e.message}" for e in walls.errors]


@pytest.mark.parametrize(
    "code",
    [
        "struct Own { void step(OwnPorts& ports); };",
        "class Own final { public: void step(auto& ports); };",
        "enum class Mode { kOwn }; class Part {}; class Own : public Base<int> {};",
        "class [[nodiscard]] Own { public: void step(OwnPorts&) { if (x) { y(); } } };",
        "using Own = Controller<3>;",
        "template <class T> class Part {}; struct Own { struct Inner {}; void step(OwnPorts&); };",
    ],
)
def test_a_class_that_the_task_can_make(code: str, project: Path) -> None:
    assert of_class(project, code) == []


@pytest.mark.parametrize(
    ("code", "message"),
    [
        (
            "class Onw { public: void step(OwnPorts& ports); };",
            "2:7: expected class 'Own' of apps/own, found class 'Onw'",
        ),
        ("void step(OwnPorts& ports);", "1:1: expected class 'Own' of apps/own, found none"),
        ("class Own;", "1:1: expected class 'Own' of apps/own, found none"),
        ("class Own {}; void step();", "2:7: missing function 'step' of class 'Own'"),
    ],
)
def test_a_class_that_is_wrong(code: str, message: str, project: Path) -> None:
    assert of_class(project, code) == [message]


def test_nodes_may_print_where_somebody_reads_it(project: Path) -> None:
    (project / "apps" / "own" / "own.hpp").write_text(f"#include <cstdio>\n{OWN}")
    node = Node(project / "apps" / "own", project / "ports" / "own")
    for may_print in (True, False):
        walls = Walls(may_print=may_print)
        walls.check_node(node)
        assert (walls.errors == []) == may_print
