"""Damages text and trees as people, editors and attackers do; all follows from one Random."""

from __future__ import annotations

import copy
import math
from random import Random
from typing import Any

import yaml

MARKER = "INJECTED"  # never to be seen outside a comment of generated code

WORDS = [
    "null", "~", "", "true", "no", "on", "010", "0x1F", "1e3", "12:30", "1_000", ".inf", "-.inf",
    ".nan", "-0", "1e999", "-1e-999", "9" * 200, "0.1", "1/3", "1 kHz", "1 khz", "300 Hz",
    "1e300 s",
    "-5 ms", "0 us", "0 Hz", "5ms", "5  ms", "45 deg", "int", "class", "namespace", "std", "stator",
    "template", "now", "params", "_x", "x_", "a__b", "topics", "uint8_t", "A", "é", "日本",
    "a" * 63,
    "a" * 64, "a b", "../../etc/passwd", "/etc/passwd", "parts/counting.yaml", "${rate}", "${}",
    "${a", "*x", "&x", "!!str", "!x", "<<", "%TAG", "|", ">", "- a", "? a", "@", "`", "{{ 7*7 }}",
    "{% raw %}", "{# x #}", f"*/ {MARKER}(); /*", f"x\n{MARKER}();", f'"; {MARKER}(); //', "x\\",
    f"x \\\n{MARKER}();", f"x\r{MARKER}();", f"x\x85{MARKER}();", f"x\u2028{MARKER}();",
    "\0", "\x07",
    "\u202e", "\u200b", "\ufeff", "??/", "$(date)", "`date`", "%s%n", "counter", "adder", "count",
    "mode", "left_count", "desk", "sitl", "fmu_v2", "imu0", "data_ready", "16", "15", "0", "-1",
]  # fmt: skip
HOSTILE = [word for word in WORDS if MARKER in word or "7*7" in word or "\\" in word]
KEYS = [
    "board", "include", "nodes", "topics", "modes", "chains", "doc", "trigger", "inputs", "outputs",
    "params", "device", "app", "priority", "deadline", "budget", "irq", "topic", "every", "offset",
    "min_interval", "max_interval", "min_interarrival", "read", "max_age", "log", "depth",
    "publishers", "initial", "sets", "path", "file", "with", "prefix", "machines", "fields", "type",
    "unit", "values", "message", "optional", "default", "range", "lines", "reads_log", "executor",
    "devices", "driver", "class", "chip", "timestamp", "xyz", "operator",
]  # fmt: skip
CHARACTERS = (
    " \t\n\r{}[],:#&*!|>'\"%@`?-\\$\0\x07\x1b\x85\xa0é\u2028\u202e\ufeff\U0001f681" + "a0_."
)


def mutate_text(text: str, random: Random) -> str:
    lines = text.split("\n")
    at = random.randrange(len(lines))
    where = random.randrange(len(text) + 1)
    until = min(len(text), where + random.randrange(1, 12))
    choice = random.randrange(10)
    if choice == 0:
        del lines[at]
    elif choice == 1:
        lines.insert(at, lines[random.randrange(len(lines))])
    elif choice == 2:
        other = random.randrange(len(lines))
        lines[at], lines[other] = lines[other], lines[at]
    elif choice == 3:
        lines[at] = " " * random.randrange(9) + lines[at].lstrip()
    elif choice == 4:
        return text[:where] + text[until:]
    elif choice == 5:
        return (
            text[:where]
            + random.choice(CHARACTERS) * random.choice([1, 1, 1, 2, 40])
            + text[where:]
        )
    elif choice == 6:
        return text[:where] + random.choice(WORDS) + text[until:]
    elif choice == 7:
        return text[:where]
    elif choice == 8:
        return text.replace("\n", random.choice(["\r\n", "\r", "\n\n", "\x85"]))
    else:
        bracket = random.choice("[{")
        return text[:where] + bracket * random.choice([1, 3, 40, 3000]) + text[where:]
    return "\n".join(lines)


def mutate_tree(text: str, random: Random) -> str:
    """Damages what the text means. Comments and spelling are lost on the way."""
    tree = yaml.safe_load(text)
    places = list(_places(tree))
    if not places:
        return text
    parent, key = random.choice(places)
    choice = random.randrange(9)
    value = _weird(random, places)
    if choice == 0:
        del parent[key]
    elif choice == 1 and isinstance(parent, dict):
        _rename(parent, key, random.choice([*KEYS, *WORDS, f"{key}x", str(key)[:-1]]))
    elif choice == 2 and isinstance(parent, dict):
        parent[random.choice(KEYS)] = value
    elif choice == 3:
        other, other_key = random.choice(places)
        parent[key], other[other_key] = copy.deepcopy(other[other_key]), copy.deepcopy(parent[key])
    elif choice == 4 and isinstance(parent, list):
        parent.append(copy.deepcopy(parent[key]))
    elif choice == 5:
        parent[key] = _nested(random, value)
    elif choice == 6:
        texts = [(p, k) for p, k in places if k in ("doc", "unit")]
        parent, key = random.choice(texts or places)
        parent[key] = f"{random.choice(['', 'It. '])}{random.choice(HOSTILE)}"
    elif choice == 7:
        parent[key] = f"{parent[key]}{random.choice(list(CHARACTERS))}"
    else:
        parent[key] = value
    return yaml.safe_dump(
        tree,
        sort_keys=False,
        allow_unicode=random.random() < 0.5,
        default_flow_style=random.choice([None, True, False]),
        width=math.inf,
    )


def _places(tree: Any, depth: int = 0) -> Any:
    if depth > 20:
        return
    pairs = (
        tree.items()
        if isinstance(tree, dict)
        else enumerate(tree)
        if isinstance(tree, list)
        else ()
    )
    for key, value in pairs:
        yield tree, key
        yield from _places(value, depth + 1)


def _rename(parent: dict[Any, Any], key: Any, new: str) -> None:
    items = [(new if name == key else name, value) for name, value in parent.items()]
    parent.clear()
    parent.update(items)


def _weird(random: Random, places: list[tuple[Any, Any]]) -> Any:
    choice = random.randrange(8)
    if choice == 0:
        parent, key = random.choice(places)
        return copy.deepcopy(parent[key])
    if choice == 1:
        return random.choice([0, -1, 7, 10**30, 0.1, math.inf, math.nan, True, False, None])
    if choice == 2:
        return {random.choice(KEYS): random.choice(WORDS)}
    if choice == 3:
        return [random.choice(WORDS) for _ in range(random.randrange(4))]
    return random.choice(WORDS)


def _nested(random: Random, value: Any) -> Any:
    for _ in range(random.choice([1, 2, 10, 60])):
        value = [value] if random.random() < 0.5 else {random.choice(KEYS): value}
    return value
