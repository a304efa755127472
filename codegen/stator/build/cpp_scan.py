"""What a C++ file includes, and what it declares outside a namespace: enough of the grammar for
walls, from the text alone."""

from __future__ import annotations

import re
from bisect import bisect_right
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from stator.diagnostics import Mark

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

_TOKEN = re.compile(
    r"""
    (?P<space>\s+ | \\\r?\n | //(?:\\\r?\n|[^\n])* | /\*.*?(?:\*/|\Z))
    | (?P<directive>(?:\#|%:)(?:\\\r?\n|/\*.*?\*/|(?!//)[^\n])*)
    | (?P<text>(?:u8|[uUL])?R"(?P<fence>[^()\\\s]{0,16})\(.*?\)(?P=fence)"
        | (?:u8|[uUL])?"(?:\\.|[^"\\\n])*"
        | (?:u8|[uUL])?'(?:\\.|[^'\\\n])*')
    | (?P<word>[A-Za-z_]\w*)
    | (?P<number>\.?\d(?:'?\w|[eEpP][+-]|\.)*)
    | (?P<sign>::|.)
    """,
    re.VERBOSE | re.DOTALL,
)
_COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
_JOINED = re.compile(r"\\\r?\n")
_DIRECTIVE = re.compile(r"(?:#|%:)\s*(?P<name>\w+)\s*(?P<rest>.*)", re.DOTALL)
_NAMED = re.compile(r'"([^"\n]*)"|<([^>\n]*)>')
_INCLUDES = ("include", "include_next", "import")


class Include(NamedTuple):
    name: str  # without quotes or brackets; empty where a macro makes it
    is_quoted: bool
    mark: Mark


class Outside(NamedTuple):
    """A declaration outside the namespace where it belongs."""

    words: str  # how it begins
    namespace: str  # where it stands; empty: in none
    mark: Mark


class Class(NamedTuple):
    name: str
    has_bases: bool  # or is another name of a type: its members are elsewhere
    words: frozenset[str]  # in its body
    mark: Mark


class _Token(NamedTuple):
    kind: str
    text: str
    at: int


@dataclass
class _Scopes:
    """Where the reader stands. A scope is a namespace's names, or None for another block."""

    open: list[tuple[str, ...] | None] = field(default_factory=list)
    declaration: list[_Token] = field(default_factory=list)

    def copy(self) -> _Scopes:
        return _Scopes(list(self.open), list(self.declaration))


class Source:
    def __init__(self, file: Path) -> None:
        self._file = file
        self._text = file.read_bytes().decode(errors="replace")
        self._starts = [0, *(match.end() for match in re.finditer("\n", self._text))]

    def includes(self) -> Iterator[Include]:
        for token in self._tokens():
            name, rest = _directive(token)
            if name in _INCLUDES:
                found = _NAMED.match(rest)
                quoted, bracketed = found.groups() if found else ("", None)
                yield Include(quoted or bracketed or "", bracketed is None, self._mark(token.at))

    def classes(self) -> Iterator[Class]:
        """Classes and structs that it defines outside of others, and names of types."""
        tokens = [token for token in self._tokens() if token.kind != "directive"]
        for i, token in enumerate(tokens[:-2]):
            name = tokens[i + 1]
            if token.text == "using" and name.kind == "word" and tokens[i + 2].text == "=":
                yield Class(name.text, True, frozenset(), self._mark(name.at))
            if token.text not in ("class", "struct"):
                continue
            if i and tokens[i - 1].text == "enum":
                continue
            if name.text == "[":  # attributes
                end = next((j for j in range(i, len(tokens)) if tokens[j].text == "]"), i) + 2
                name = tokens[min(end, len(tokens) - 1)]
            after = tokens.index(name) + 1
            rest = tokens[after : after + 2]
            has_bases = bool(rest) and rest[0].text in (":", "final") and rest[-1].text != "{"
            if rest and (rest[0].text in ("{", ":") or rest[0].text == "final"):
                words = frozenset(_words_of_body(tokens, after))
                yield Class(name.text, has_bases, words, self._mark(name.at))

    def outside(self, own: tuple[str, ...]) -> Iterator[Outside]:
        """Declarations that another file's could be taken for: neither in the namespace `own` nor
        in one without a name. Declared names of types and `using` are not."""
        here = _Scopes()
        branches: list[_Scopes] = []
        for token in self._tokens():
            if token.kind == "directive":
                here = _branch(here, branches, _directive(token)[0])
                continue
            if any(scope is None for scope in here.open):  # in a body
                _enter_or_leave(here, token.text, None)
                continue
            namespace = tuple(name for scope in here.open for name in scope or ())
            if token.text == "{" and _is_namespace(here.declaration):
                here.open.append(_names(here.declaration))
                here.declaration.clear()
            elif token.text in "{};":
                begun = here.declaration
                is_own = _is_inside(namespace, own) and not _has_c_linkage(begun)
                if begun and not is_own and not _is_harmless(begun, token.text):
                    shown = " ".join(t.text for t in begun[:4]).replace(" :: ", "::")
                    shown += "" if len(begun) < 5 else " ..."
                    yield Outside(shown, "::".join(namespace), self._mark(begun[0].at))
                _enter_or_leave(here, token.text, None)
                here.declaration.clear()
            else:
                here.declaration.append(token)

    def _tokens(self) -> Iterator[_Token]:
        for match in _TOKEN.finditer(self._text):
            if match.lastgroup != "space":
                kind = match.lastgroup or ""
                yield _Token("text" if kind == "fence" else kind, match.group(), match.start())

    def _mark(self, at: int) -> Mark:
        line = bisect_right(self._starts, at)
        return Mark(self._file, line, at - self._starts[line - 1] + 1)


def _words_of_body(tokens: list[_Token], start: int) -> Iterator[str]:
    depth = 0
    for token in tokens[start:]:
        depth += (token.text == "{") - (token.text == "}")
        if token.kind == "word" and depth > 0:
            yield token.text
        if token.text == "}" and depth == 0:
            return


def _directive(token: _Token) -> tuple[str, str]:
    if token.kind != "directive":
        return "", ""
    match = _DIRECTIVE.match(_COMMENT.sub(" ", _JOINED.sub("", token.text)))
    return (match["name"], match["rest"]) if match else ("", "")


def _branch(here: _Scopes, branches: list[_Scopes], name: str) -> _Scopes:
    """Each branch of a condition begins where the condition did; the last one goes on."""
    if name in ("if", "ifdef", "ifndef"):
        branches.append(here.copy())
    elif name in ("else", "elif", "elifdef", "elifndef") and branches:
        return branches[-1].copy()
    elif name == "endif" and branches:
        branches.pop()
    return here


def _enter_or_leave(here: _Scopes, text: str, scope: tuple[str, ...] | None) -> None:
    if text == "{":
        here.open.append(scope)
    elif text == "}" and here.open:
        here.open.pop()


def _is_namespace(declaration: list[_Token]) -> bool:
    words = [token.text for token in declaration]
    return "namespace" in words[:2] or (len(words) == 2 and words[0] == "extern")


def _names(declaration: list[_Token]) -> tuple[str, ...]:
    """Of a namespace that opens: one without a name is <unnamed>; names in C linkage have none."""
    if declaration[0].text == "extern":
        return ('extern "C"',)
    words = [token.text for token in declaration if token.kind == "word"]
    names = tuple(word for word in words if word not in ("inline", "namespace"))
    return names or ("<unnamed>",)


def _is_inside(namespace: tuple[str, ...], own: tuple[str, ...]) -> bool:
    if 'extern "C"' in namespace:
        return False
    return "<unnamed>" in namespace or namespace[: len(own)] == own


def _has_c_linkage(declaration: list[_Token]) -> bool:
    return [token.text for token in declaration[:1]] == ["extern"] and any(
        token.kind == "text" for token in declaration[1:2]
    )


_TYPE = ("class", "struct", "union", "enum")


def _is_harmless(declaration: list[_Token], end: str) -> bool:
    words = [token.text for token in declaration]
    if end != ";":
        return False
    if words[0] in ("static_assert", "namespace") or words[:2] == ["using", "namespace"]:
        return True
    if words[0] == "using":
        return "=" not in words
    # `class X;`, `enum class X : int;`, `template <class T> struct X;`
    begin = words.index(">") + 1 if words[0] == "template" and ">" in words else 0
    kind, rest = words[begin : begin + 1], declaration[begin + 1 :]
    if kind == ["enum"]:
        return all(token.kind == "word" or token.text in ("::", ":") for token in rest)
    return bool(kind) and kind[0] in _TYPE and len(rest) == 1
