"""Composition: what a file writes replaces, key by key, what it includes."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from stator import language, yaml_tree
from stator.diagnostics import Mark, Report, nearest
from stator.shapes import Listing, Record, kind
from stator.yaml_tree import Mapping, Scalar, Sequence, Tree

if TYPE_CHECKING:
    from pathlib import Path

MOST_INCLUDES = 200
_VARIABLE = re.compile(r"\$\{([^}]*)\}")


@dataclass
class Composer:
    """Reads a graph file and all that it includes."""

    report: Report
    roots: tuple[Path, ...]  # folders that includes may come from
    files: list[Path] = field(default_factory=list)
    _includes: int = 0

    def compose(self, path: Path, above: tuple[Path, ...] = ()) -> Mapping | None:
        tree = yaml_tree.load(path, self.report)
        if path not in self.files:
            self.files.append(path)
        if tree is None:
            return None
        if not isinstance(tree, Mapping):
            self.report.error(tree.mark, "wrong-shape", f"a graph is a mapping, not {kind(tree)}",
                              "its keys: " + ", ".join(language.GRAPH.keys))
            return None
        if "include" not in tree.entries:
            return tree
        included = Listing(language.INCLUDE).read(tree.entries["include"], self.report)
        own = _without(tree, "include")
        if included is None:
            return own
        base: Mapping | None = None
        for record in included.value:
            part = self._include(record, path, (*above, path))
            if part is not None:
                base = part if base is None else self._join(base, part)
        return own if base is None else _override(base, own)

    def _include(self, record: Record, path: Path, above: tuple[Path, ...]) -> Mapping | None:
        leaf = record.get("file")
        if leaf is None:
            return None
        file = (path.parent / leaf.value).resolve()
        if not any(file.is_relative_to(root) for root in self.roots):
            self.report.error(leaf.mark, "include-path",
                              f"'{leaf.value}' lies outside the graph's folder",
                              f"put it below {self.roots[0]}")
            return None
        if not file.is_file():
            known = [str(p.relative_to(path.parent.resolve()))
                     for p in sorted(file.parent.glob("*.yaml"))[:50]
                     if p.is_relative_to(path.parent.resolve())]
            self.report.error(leaf.mark, "include-missing", f"there is no file '{leaf.value}'",
                              nearest(leaf.value, known))
            return None
        if file in above:
            self.report.error(leaf.mark, "include-cycle", f"'{leaf.value}' includes itself",
                              "remove one of the includes on the way round")
            return None
        self._includes += 1
        if self._includes > MOST_INCLUDES:
            self.report.error(leaf.mark, "include-cycle", f"more than {MOST_INCLUDES} includes")
            return None
        part = self.compose(file, above)
        if part is None:
            return None
        part = self._substitute(part, record)
        prefix = record.value("prefix", "")
        return _prefixed(part, prefix) if prefix else part

    def _substitute(self, part: Mapping, record: Record) -> Mapping:
        given = record.get("with")
        values: dict[str, Scalar] = given.values if given is not None else {}
        used: set[str] = set()

        def replace(tree: Tree) -> Tree:
            if isinstance(tree, Mapping):
                entries = {key: replace(item) for key, item in tree.entries.items()}
                return Mapping(entries, tree.mark, tree.keys)
            if isinstance(tree, Sequence):
                return Sequence([replace(item) for item in tree.items], tree.mark)
            match = _VARIABLE.fullmatch(tree.text)
            if match is None:
                return tree
            name = match.group(1)
            if name not in values:
                self.report.error(tree.mark, "variable-unknown", f"'{tree.text}' has no value",
                                  nearest(name, values) or f"write `with: {{{name}: ...}}` where "
                                  "the file is included")
                return tree
            used.add(name)
            return values[name]

        result = replace(part)
        assert isinstance(result, Mapping)
        for name in values:
            if name not in used:
                mark = given.keys[name] if given is not None else record.mark
                self.report.error(mark, "variable-unused",
                                  f"'{name}' stands nowhere in the included file as ${{{name}}}")
        return result

    def _join(self, first: Mapping, second: Mapping) -> Mapping:
        """Two includes side by side: they may add, not differ."""
        entries, keys = dict(first.entries), dict(first.keys)
        for key, item in second.entries.items():
            old = entries.get(key)
            if old is None:
                entries[key], keys[key] = item, second.keys[key]
            elif isinstance(old, Mapping) and isinstance(item, Mapping):
                entries[key] = self._join(old, item)
            elif _plain(old) != _plain(item):
                where: Mark = first.keys[key]
                self.report.error(second.keys[key], "include-conflict",
                                  f"two includes differ on '{key}'",
                                  f"the other is {where.file.name}:{where.line}; write the key in "
                                  "the including file")
        return Mapping(entries, first.mark, keys)


def check_variables(tree: Tree, report: Report) -> None:
    """Variables of the top file have nobody to give them a value."""
    if isinstance(tree, Mapping):
        for item in tree.entries.values():
            check_variables(item, report)
    elif isinstance(tree, Sequence):
        for item in tree.items:
            check_variables(item, report)
    elif _VARIABLE.fullmatch(tree.text):
        report.error(tree.mark, "variable-unknown", f"'{tree.text}' has no value",
                     "include this file from another one, with `with`")


def _without(tree: Mapping, key: str) -> Mapping:
    entries = {k: v for k, v in tree.entries.items() if k != key}
    return Mapping(entries, tree.mark, tree.keys)


def _override(base: Mapping, own: Mapping) -> Mapping:
    entries, keys = dict(base.entries), dict(base.keys)
    for key, item in own.entries.items():
        old = entries.get(key)
        if isinstance(item, Scalar) and item.is_null and old is not None:
            del entries[key]
            continue
        if isinstance(old, Mapping) and isinstance(item, Mapping):
            item = _override(old, item)
        entries[key], keys[key] = item, own.keys[key]
    return Mapping(entries, own.mark, keys)


def _plain(tree: Tree) -> Any:
    if isinstance(tree, Mapping):
        return {key: _plain(item) for key, item in tree.entries.items()}
    if isinstance(tree, Sequence):
        return [_plain(item) for item in tree.items]
    return tree.text


def _prefixed(part: Mapping, prefix: str) -> Mapping:
    """The part with `prefix` before its node names and the topics that it publishes."""
    nodes = part.entries.get("nodes")
    if not isinstance(nodes, Mapping):
        return part
    topics = {item.text for node in nodes.entries.values() for item in _outputs(node)}

    def rename(tree: Tree, names: set[str]) -> Tree:
        if isinstance(tree, Mapping):
            entries = {key: rename(item, names) for key, item in tree.entries.items()}
            return Mapping(entries, tree.mark, tree.keys)
        if isinstance(tree, Sequence):
            return Sequence([rename(item, names) for item in tree.items], tree.mark)
        if tree.text in names:
            return Scalar(prefix + tree.text, tree.mark, tree.quoted)
        return tree

    def rename_node(name: str, node: Tree) -> Tree:
        if not isinstance(node, Mapping):
            return node
        entries, keys = dict(node.entries), dict(node.keys)
        for key in ("trigger", "inputs", "outputs"):
            if key in entries:
                entries[key] = rename(entries[key], topics)
        if "app" not in entries and "device" not in entries:
            entries["app"], keys["app"] = Scalar(name, nodes.keys[name]), nodes.keys[name]
        return Mapping(entries, node.mark, keys)

    def rename_keys(table: Mapping, names: set[str] | None) -> Mapping:
        def new(key: str) -> str:
            return prefix + key if names is None or key in names else key

        return Mapping({new(key): item for key, item in table.entries.items()}, table.mark,
                       {new(key): mark for key, mark in table.keys.items()})

    entries = dict(part.entries)
    renamed = {name: rename_node(name, node) for name, node in nodes.entries.items()}
    entries["nodes"] = rename_keys(Mapping(renamed, nodes.mark, nodes.keys), None)
    configured = entries.get("topics")
    if isinstance(configured, Mapping):
        entries["topics"] = rename_keys(configured, topics)
    chains = entries.get("chains")
    if isinstance(chains, Mapping):
        entries["chains"] = rename_keys(Mapping(
            {key: rename(item, set(nodes.entries)) for key, item in chains.entries.items()},
            chains.mark, chains.keys), None)
    if "modes" in entries:
        entries["modes"] = rename(entries["modes"], set(nodes.entries))
    return Mapping(entries, part.mark, part.keys)


def _outputs(node: Tree) -> list[Scalar]:
    outputs = node.entries.get("outputs") if isinstance(node, Mapping) else None
    if not isinstance(outputs, Mapping):
        return []
    return [item for item in outputs.entries.values() if isinstance(item, Scalar)]
