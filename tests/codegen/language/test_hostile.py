"""Input that means harm, or comes from a broken disk: bounded work, clean errors, nothing read from
outside the graph's folder."""

from __future__ import annotations

import os
import shutil
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from stator.diagnostics import Error, Failed, Report
from stator.graph.check import check
from stator.language import yaml_tree
from stator.names import reserved_reason

BAD = Path(__file__).parent / "bad"
GOOD = "board: bench\nnodes:\n  source: {trigger: {every: 10 ms}, outputs: {sample: raw}}\n"


@pytest.fixture(autouse=True)
def bounded() -> Iterator[None]:
    """A hang ends, as the death of the test."""
    signal.alarm(60)
    yield
    signal.alarm(0)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in ("apps", "messages", "drivers", "boards"):
        (tmp_path / name).symlink_to(BAD / name)
    return tmp_path


def errors(path: Path) -> list[Error]:
    with pytest.raises(Failed) as failed:
        check(path)
    assert all(error.text() for error in failed.value.errors)
    return failed.value.errors


def errors_of(folder: Path, content: str | bytes) -> list[str]:
    graph = folder / "graph.yaml"
    graph.write_bytes(content if isinstance(content, bytes) else content.encode())
    return [error.rule for error in errors(graph)]


def test_the_plain_graph_is_good(folder: Path) -> None:
    (folder / "graph.yaml").write_text(GOOD)
    check(folder / "graph.yaml")


@pytest.mark.parametrize("content", [
    b"\xef\xbb\xbf" + GOOD.encode(),
    GOOD.replace("\n", "\r\n").encode(),
    GOOD.replace("\n", "\r").encode(),
    b"# comment\n---\n" + GOOD.encode(),
], ids=["byte order mark", "CRLF", "CR", "start of document"])  # fmt: skip
def test_what_editors_do_to_files_is_no_error(folder: Path, content: bytes) -> None:
    (folder / "graph.yaml").write_bytes(content)
    check(folder / "graph.yaml")


def test_aliases_that_explode(folder: Path) -> None:
    laughs = "a: &a [x]\n" + "".join(
        f"{b}: &{b} [{', '.join(['*' + a] * 10)}]\n"
        for a, b in zip("abcdefgh", "bcdefghi", strict=True)
    )
    assert errors_of(folder, laughs) == ["yaml-alias"]


@pytest.mark.parametrize("opening", ["[", "{a: ", "- ", "? ", "- - {a: ["])
def test_nesting(folder: Path, opening: str) -> None:
    (rule,) = errors_of(folder, "board: bench\nnodes:\n  " + opening * 200_000)
    assert rule in ("yaml-depth", "yaml-syntax", "wrong-shape")


def test_block_nesting(folder: Path) -> None:
    text = "".join(" " * i + "a:\n" for i in range(2_000))
    assert errors_of(folder, text) == ["yaml-depth"]


@pytest.mark.parametrize("content", [
    b"\0", b"\0" * 100_000, b"board: bench\0\n", b"\xff\xfe" + GOOD.encode("utf-16-le"),
    b"\xc3\x28", b"\xed\xa0\x80", b"\xf8\x88\x80\x80\x80", b"board: \x7f\n",
])  # fmt: skip
def test_no_text(folder: Path, content: bytes) -> None:
    assert errors_of(folder, content) == ["encoding"]


@pytest.mark.parametrize("content", [b"", b"\n" * 1000, b"---\n", b"# only\n", b"null\n", b"~"])
def test_nothing(folder: Path, content: bytes) -> None:
    assert errors_of(folder, content) == ["yaml-empty"]


@pytest.mark.parametrize(
    "number", ["9" * 60, "9" * 10_000, "1e999", "-1e999", "1e-999", "0x10", "1/3"]
)
@pytest.mark.parametrize("where", ["every: {} ms", "every: {} Hz", "every: {}"])
def test_numbers(folder: Path, number: str, where: str) -> None:
    assert len(errors_of(folder, GOOD.replace("every: 10 ms", where.format(number)))) == 1


def test_many_errors(folder: Path) -> None:
    """All of them are reported, in order, in bounded time: hints stop before they cost minutes."""
    nodes = "".join(f"  n{i}: {{app: sorce{i}, trigger: {{every: 1 s}}}}\n" for i in range(5_000))
    found = errors_of(folder, "board: bench\nnodes:\n" + nodes)
    assert found == ["app-unknown"] * 5_000


def test_a_long_line(folder: Path) -> None:
    (folder / "graph.yaml").write_text("board: [" + "x, " * 100_000 + "]\n")
    (error, *_) = errors(folder / "graph.yaml")
    assert len(error.text()) < 2_000


# --- files ---


def test_no_such_file(folder: Path) -> None:
    (error,) = errors(folder / "nothing.yaml")
    assert error.rule == "file-missing"


def test_a_folder(folder: Path) -> None:
    (folder / "graph.yaml").mkdir()
    (error,) = errors(folder / "graph.yaml")
    assert "a folder" in error.message


@pytest.mark.parametrize("device", ["/dev/zero", "/dev/null", "/dev/stdin"])
def test_a_device(folder: Path, device: str) -> None:
    (folder / "graph.yaml").symlink_to(device)
    assert errors(folder / "graph.yaml")[0].rule in (
        "file-missing",
        "yaml-empty",
    )


def test_a_pipe(folder: Path) -> None:
    os.mkfifo(folder / "graph.yaml")
    (error,) = errors(folder / "graph.yaml")
    assert error.rule == "file-missing"


def test_a_link_to_itself(folder: Path) -> None:
    (folder / "graph.yaml").symlink_to("graph.yaml")
    (error,) = errors(folder / "graph.yaml")
    assert error.rule == "file-missing"


def test_a_file_that_may_not_be_read(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Tests may run as a user who may read everything, so the system's answer is played."""
    (folder / "graph.yaml").write_text(GOOD)

    def refuse(path: Path) -> bytes:
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "read_bytes", refuse)
    (error,) = errors(folder / "graph.yaml")
    assert "Permission denied" in error.message


def test_folders_instead_of_files_of_the_library(folder: Path) -> None:
    (folder / "apps").unlink()
    (folder / "apps" / "source" / "source.yaml").mkdir(parents=True)
    assert errors_of(folder, GOOD) == ["app-unknown"]


# --- includes ---

INCLUDE = "board: bench\ninclude: [{{file: {}}}]\n"


@pytest.mark.parametrize("file", [
    "/etc/passwd", "/etc/passwd.yaml", "../outside.yaml", "../../../../../../../../etc/x.yaml",
    "parts/../../outside.yaml", "~/x.yaml", "file:///etc/x.yaml", "x.yaml/../y.yaml",
    ".hidden.yaml",
    '"a\\0b.yaml"', "a" * 5_000 + ".yaml", "a/" * 2_000 + "x.yaml", "", "..", ".", "C:\\\\x.yaml",
    '"${HOME}.yaml"', "$(id).yaml",
])  # fmt: skip
def test_include_leaves_nothing(folder: Path, file: str) -> None:
    (folder.parent / "outside.yaml").write_text("nodes: {}\n")
    (folder / "parts").mkdir()
    found = errors_of(folder, INCLUDE.format(file))
    assert len(found) == 1
    assert found[0] in ("include-path", "encoding", "wrong-shape", "variable-unknown")


@pytest.mark.parametrize("target", ["/etc/passwd", "/dev/zero", "../outside.yaml"])
def test_include_by_a_link(folder: Path, target: str) -> None:
    (folder.parent / "outside.yaml").write_text("nodes: {}\n")
    (folder / "part.yaml").symlink_to(target)
    assert errors_of(folder, INCLUDE.format("part.yaml")) == ["include-path"]


def test_include_of_a_folder(folder: Path) -> None:
    (folder / "part.yaml").mkdir()
    assert errors_of(folder, INCLUDE.format("part.yaml")) == ["include-missing"]


def test_include_bomb(folder: Path) -> None:
    """Ten times ten times ... the same files: their number is bounded, not only the depth."""
    for i in range(9):
        lines = f"  - {{file: part{i + 1}.yaml}}\n" * 10
        (folder / f"part{i}.yaml").write_text(f"include:\n{lines}")
    (folder / "part9.yaml").write_text("nodes: {}\n")
    assert set(errors_of(folder, INCLUDE.format("part0.yaml"))) == {"include-many"}


def test_include_of_much(folder: Path) -> None:
    (folder / "part.yaml").write_text("nodes: {}\n" + "# fill\n" * 500_000)
    text = "board: bench\ninclude:\n" + "  - {file: part.yaml}\n" * 150
    assert set(errors_of(folder, text)) == {"file-too-large"}


def test_variables_do_not_grow(folder: Path) -> None:
    """Values are single: a chain of includes cannot double a tree at every step."""
    for i in range(60):
        (folder / f"part{i}.yaml").write_text(
            f'include: [{{file: part{i + 1}.yaml, with: {{x: ["${{x}}", "${{x}}"]}}}}]\n'
        )
    (folder / "part60.yaml").write_text('nodes: {source: {trigger: "${x}"}}\n')
    text = "board: bench\ninclude: [{file: part0.yaml, with: {x: a}}]\n"
    assert "wrong-shape" in errors_of(folder, text)


# --- names ---


@pytest.mark.parametrize("name", ["int", "operator", "co_await", "size_t", "main", "std", "assert",
                                  "a__b", "a_", "typeof", "uint32_t"])  # fmt: skip
@pytest.mark.parametrize("place", ["node", "topic"])
def test_names_that_are_taken(folder: Path, name: str, place: str) -> None:
    text = GOOD.replace("sample: raw", f"sample: {name}")
    if place == "node":
        text = GOOD.replace("  source:", f"  {name}:").replace("{trigger", "{app: source, trigger")
    assert errors_of(folder, text) == ["reserved-name"]


def test_every_word_of_cpp_is_taken() -> None:
    words = "alignas auto bool case catch class const delete double else enum export float for goto"
    assert all(reserved_reason(word) for word in words.split())


def test_template_code_is_only_text(folder: Path) -> None:
    from stator.emit.emit import emit
    from stator.plan.plan import plan

    shutil.copytree(BAD / "apps", folder / "own" / "apps")
    shutil.copytree(BAD / "messages", folder / "own" / "messages")
    shutil.copytree(BAD / "drivers", folder / "own" / "drivers")
    shutil.copytree(BAD / "boards", folder / "own" / "boards")
    evil = '"{{ 7*7 }}{% for x in y %} */ \\\\"'
    (folder / "own" / "apps" / "source" / "source.yaml").write_text(
        f"doc: {evil}\noutputs: {{sample: {{message: Sample, doc: {evil}}}}}\n"
    )
    graph = folder / "own" / "graph.yaml"
    graph.write_text(GOOD)
    text = emit(plan(*check(graph)))["ports/source/source_ports.hpp"]
    assert "// {{ 7*7 }}{% for x in y %} */ /\n" in text


def test_parser_stops_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Counted work: what is refused early is not read to its end."""
    seen = 0
    parse = yaml_tree.yaml.parse

    def counted(*arguments: object, **named: object) -> Iterator[object]:
        nonlocal seen
        for event in parse(*arguments, **named):  # type: ignore[arg-type]
            seen += 1
            yield event

    monkeypatch.setattr(yaml_tree.yaml, "parse", counted)
    report = Report()
    yaml_tree.parse("a: &a x\n" + "b: *a\n" * 100_000, Path("x.yaml"), report)
    assert len(report) == 1
    assert seen < 10
