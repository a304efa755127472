"""Composition: the keys of a file replace, one by one, the same keys of its includes."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from stator.diagnostics import MAX_BYTES, Mark, Report, beside
from stator.language import keys as language
from stator.language import yaml_tree
from stator.language.nested import Listing
from stator.language.prefix import prefixed
from stator.language.shapes import VARIABLE, Record, misshaped
from stator.language.yaml_tree import Mapping, Scalar, Sequence, Tree

MAX_INCLUDES = 200


@dataclass
class Composer:
    """Reads a graph file and all that it includes."""

    report: Report
    roots: tuple[Path, ...]  # folders that includes may come from
    files: list[Path] = field(default_factory=list)
    is_complete: bool = True  # False: a file could not be read, so names may be missing
    _trees: dict[Path, Tree | None] = field(default_factory=dict)
    _bytes: int = 0
    _includes: int = 0

    def compose(self, path: Path, above: tuple[Path, ...] = ()) -> Mapping | None:
        self._bytes += path.stat().st_size if path.is_file() else 0
        tree = self._load(path)
        if tree is None:
            self.is_complete = False
            return None
        if not isinstance(tree, Mapping):
            self.is_complete = False
            keys = ", ".join(language.GRAPH.keys)
            misshaped(tree, "a mapping", self.report, f"known keys: {keys}")
            return None
        if "include" not in tree.entries:
            return tree
        included = Listing(language.INCLUDE).read(tree.entries["include"], self.report)
        own = _without(tree, "include")
        if included is None:
            self.is_complete = False
            return own
        base: Mapping | None = None
        for record in included.value:
            part = self._include(record, path, (*above, path))
            if part is None:
                self.is_complete = False
            else:
                base = part if base is None else self._join(base, part, own)
        return own if base is None else self._override(base, own, ())

    def _load(self, path: Path) -> Tree | None:
        """Reads each file once, even if it is included several times."""
        if path not in self._trees:
            self.files.append(path)
            self._trees[path] = yaml_tree.load(path, self.report)
        return self._trees[path]

    def _include(self, record: Record, path: Path, above: tuple[Path, ...]) -> Mapping | None:
        leaf = record.get("file")
        if leaf is None:
            return None
        # Beside the including file first, then among Stator's own graphs.
        beside_it, own = (
            Path(os.path.realpath(folder / leaf.value)) for folder in (path.parent, self.roots[-1])
        )
        file = beside_it if beside_it.is_file() or not own.is_file() else own
        if not any(file.is_relative_to(root) for root in self.roots):
            self.report.error(
                leaf.mark,
                "include-path",
                f"expected a file in the graph's folder, found '{leaf.value}'",
                "move the file into the folder of the graph, or below it",
            )
            return None
        if not file.is_file():
            self.report.error(
                leaf.mark,
                "include-missing",
                f"missing file '{leaf.value}'",
                self.report.nearest(leaf.value, _files_near(file, path.parent)),
            )
            return None
        if file in above:
            names = [step.name for step in (*above[above.index(file) :], file)]
            self.report.error(
                leaf.mark,
                "include-cycle",
                "includes form a cycle: "
                + " -> ".join(names if len(names) < 8 else [*names[:6], "...", names[-1]]),
                "remove one of these includes",
            )
            return None
        self._includes += 1
        if self._includes > MAX_INCLUDES:
            self.report.error(
                leaf.mark,
                "include-many",
                f"expected at most {MAX_INCLUDES} includes, found more",
                "include fewer files; a file that is included twice counts twice",
            )
            return None
        if self._bytes > MAX_BYTES:
            self.report.error(
                leaf.mark,
                "file-too-large",
                f"expected at most {MAX_BYTES} bytes in all included files, found more",
                "include fewer or smaller files",
            )
            return None
        part = self.compose(file, above)
        if part is None:
            return None
        part = self._substitute(part, record)
        prefix = record.value("prefix", "")
        return prefixed(part, prefix) if prefix else part

    def _substitute(self, part: Mapping, record: Record) -> Mapping:
        given = record.get("with")
        values: dict[str, Scalar] = given.values if given is not None else {}
        used: set[str] = set()
        unknown: set[str] = set()

        def replace(tree: Tree) -> Tree:
            if isinstance(tree, Mapping):
                entries = {key: replace(item) for key, item in tree.entries.items()}
                return Mapping(entries, tree.mark, tree.keys, tree.owner)
            if isinstance(tree, Sequence):
                return Sequence([replace(item) for item in tree.items], tree.mark)
            match = VARIABLE.fullmatch(tree.text)
            if match is None:
                return tree
            name = match.group(1)
            if name in values:
                used.add(name)
                return values[name]
            unknown.add(name)
            if given is None or name not in given.keys:
                known = self.report.nearest(name, values)
                self.report.error(
                    tree.mark,
                    "variable-unknown",
                    f"variable {tree.text[:60]} has no value",
                    known
                    or f"add `with: {{{name[:60]}: VALUE}}` to the include in "
                    f"{beside(tree.mark, record.mark)}",
                )
            # A value that stands for the missing one: no second error about it.
            return tree

        result = replace(part)
        assert isinstance(result, Mapping)
        for name in values:
            if name not in used and not get_close_matches(name, unknown):
                mark = given.keys[name] if given is not None else record.mark
                self.report.error(
                    mark,
                    "variable-unused",
                    f"the included file does not use the variable ${{{name}}}",
                    f"remove it, or write ${{{name}}} for a whole value in the included file",
                )
        return result

    def _join(self, first: Mapping, second: Mapping, own: Tree | None) -> Mapping:
        """Two includes side by side. They may not differ on a key, unless the including file
        (`own`) writes that key itself."""
        entries, keys = dict(first.entries), dict(first.keys)
        for key, item in second.entries.items():
            old = entries.get(key)
            decided = own.entries.get(key) if isinstance(own, Mapping) else None
            if old is None:
                entries[key], keys[key] = item, second.keys[key]
            elif isinstance(old, Mapping) and isinstance(item, Mapping):
                entries[key] = self._join(old, item, decided)
            elif decided is None and _plain(old) != _plain(item):
                self._refuse_conflict(key, first.keys[key], second.keys[key])
        return Mapping(entries, first.mark, keys, first.owner)

    def _override(self, base: Mapping, own: Mapping, path: tuple[str, ...]) -> Mapping:
        entries, keys = dict(base.entries), dict(base.keys)
        for key, item in own.entries.items():
            old = entries.get(key)
            if isinstance(item, Scalar) and item.is_null:
                if old is not None:
                    del entries[key], keys[key]
                    continue
                if item.text and self.is_complete:
                    self._refuse_null(own.keys[key], key, base)
                    continue
            if isinstance(old, Scalar) and isinstance(item, Mapping) and _is_input(path):
                # `gyro: sensor_gyro` is short for `gyro: {topic: sensor_gyro}`.
                old = Mapping({"topic": old}, old.mark, {"topic": old.mark}, keys[key])
            if isinstance(old, Mapping) and isinstance(item, Mapping):
                item = self._override(old, item, (*path, key))
            entries[key], keys[key] = item, own.keys[key]
        return Mapping(entries, own.mark, keys, own.owner)

    def _refuse_null(self, mark: Mark, key: str, base: Mapping) -> None:
        self.report.error(
            mark,
            "include-null",
            f"null removes a key of an included file, and none has '{key[:60]}' here",
            self.report.nearest(key, base.entries),
        )

    def _refuse_conflict(self, key: str, first: Mark, second: Mark) -> None:
        hint = f"other value: {beside(second, first)}; write the key in the including file"
        if first.file == second.file:
            hint = "this file is included twice; add `prefix` to one of the includes"
        self.report.error(
            second, "include-conflict", f"two includes differ on key '{key[:60]}'", hint
        )


def check_variables(tree: Tree, report: Report) -> None:
    """Reports each variable of the top file: no including file can give it a value."""
    if isinstance(tree, Mapping):
        for item in tree.entries.values():
            check_variables(item, report)
    elif isinstance(tree, Sequence):
        for item in tree.items:
            check_variables(item, report)
    elif tree.text.startswith("${") and VARIABLE.fullmatch(tree.text):
        report.error(
            tree.mark,
            "variable-unknown",
            f"variable {tree.text[:60]} has no value",
            "include this file from another file, and give the value in `with`",
        )


def _files_near(file: Path, folder: Path) -> list[str]:
    """Files in the folder of `file`, with the paths that an include in `folder` would use."""
    try:
        found = sorted(path for path in file.parent.glob("*.yaml") if path.is_file())[:50]
        return [os.path.relpath(path, folder) for path in found]
    except OSError:
        return []


def _without(tree: Mapping, key: str) -> Mapping:
    entries = {k: v for k, v in tree.entries.items() if k != key}
    keys = {k: v for k, v in tree.keys.items() if k != key}
    return Mapping(entries, tree.mark, keys, tree.owner)


def _is_input(path: tuple[str, ...]) -> bool:
    return len(path) == 3 and path[0] == "nodes" and path[2] == "inputs"


def _plain(tree: Tree) -> Any:
    if isinstance(tree, Mapping):
        return {key: _plain(item) for key, item in tree.entries.items()}
    if isinstance(tree, Sequence):
        return [_plain(item) for item in tree.items]
    return tree.text
