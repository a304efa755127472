"""`include` with `prefix`: renames the nodes of a part, and the topics that it publishes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stator.language.yaml_tree import Mapping, Scalar, Sequence, Tree

if TYPE_CHECKING:
    from collections.abc import Callable


def prefixed(part: Mapping, prefix: str) -> Mapping:
    """The part with `prefix` in front of its nodes, chains and the topics that it publishes."""
    nodes = part.entries.get("nodes")
    if not isinstance(nodes, Mapping):
        return part
    topics = {item.text for node in nodes.entries.values() for item in _outputs(node)}

    def topic(tree: Tree) -> Tree:
        return _renamed(tree, prefix, topics)

    def node(tree: Tree) -> Tree:
        return _renamed(tree, prefix, set(nodes.entries))

    def names(tree: Tree) -> Tree:
        return _each(tree, node)

    result = dict(part.entries)
    renamed = {name: _node(name, item, nodes, topic) for name, item in nodes.entries.items()}
    result["nodes"] = _keys(nodes._replace(entries=renamed), prefix, None)
    if "topics" in result:
        result["topics"] = _keys(result["topics"], prefix, topics)
    if "chains" in result:
        chains = _each(result["chains"], lambda chain: _at(chain, "path", names))
        result["chains"] = _keys(chains, prefix, None)
    if "modes" in result:
        result["modes"] = _at(result["modes"], "sets", lambda sets: _each(sets, names))
    return part._replace(entries=result)


def _node(name: str, tree: Tree, nodes: Mapping, topic: Callable[[Tree], Tree]) -> Tree:
    """The node, renamed topics included. If it names no app, its old name is its app."""
    if not isinstance(tree, Mapping):
        return tree
    tree = _at(tree, "outputs", lambda outputs: _each(outputs, topic))
    tree = _at(
        tree,
        "inputs",
        lambda inputs: _each(
            inputs,
            lambda item: topic(item) if isinstance(item, Scalar) else _at(item, "topic", topic),
        ),
    )
    tree = _at(
        tree,
        "trigger",
        lambda trigger: (
            _each(trigger, lambda item: _at(item, "topic", topic))
            if isinstance(trigger, Sequence)
            else _at(trigger, "topic", topic)
        ),
    )
    assert isinstance(tree, Mapping)
    if "app" in tree.entries or "device" in tree.entries:
        return tree
    mark = nodes.keys[name]
    return tree._replace(
        entries={**tree.entries, "app": Scalar(name, mark)}, keys={**tree.keys, "app": mark}
    )


def _renamed(tree: Tree, prefix: str, names: set[str]) -> Tree:
    if isinstance(tree, Scalar) and tree.text in names:
        return Scalar(prefix + tree.text, tree.mark, tree.quoted)
    return tree


def _each(tree: Tree, change: Callable[[Tree], Tree]) -> Tree:
    """Every item of a list, or every value of a mapping, changed."""
    if isinstance(tree, Mapping):
        return tree._replace(entries={key: change(item) for key, item in tree.entries.items()})
    if isinstance(tree, Sequence):
        return tree._replace(items=[change(item) for item in tree.items])
    return tree


def _at(tree: Tree, key: str, change: Callable[[Tree], Tree]) -> Tree:
    """The mapping with the value of one key changed, if it has the key."""
    if not isinstance(tree, Mapping) or key not in tree.entries:
        return tree
    return tree._replace(entries={**tree.entries, key: change(tree.entries[key])})


def _keys(tree: Tree, prefix: str, names: set[str] | None) -> Tree:
    """A mapping with its keys renamed; `names` None means all of them."""
    if not isinstance(tree, Mapping):
        return tree

    def new(key: str) -> str:
        return prefix + key if names is None or key in names else key

    return tree._replace(
        entries={new(key): item for key, item in tree.entries.items()},
        keys={new(key): mark for key, mark in tree.keys.items()},
    )


def _outputs(node: Tree) -> list[Scalar]:
    outputs = node.entries.get("outputs") if isinstance(node, Mapping) else None
    if not isinstance(outputs, Mapping):
        return []
    return [item for item in outputs.entries.values() if isinstance(item, Scalar)]
