"""Hostile and broken input: files that this package reads, changed at random by a generator, and names of agents."""

import json
import struct
from typing import Any

import numpy as np

from support.mutations import Place, at, leaves, other, put

Rng = np.random.Generator

VALUES: tuple[Any, ...] = (
    None, True, False, -1, 0, 1, 7, 2**53 + 1, 10**40, "HUGE", -0.0, 0.5, 1e308, -1e308, float("nan"), float("inf"),
    "", "x", "x" * 5000, "../../x", "/x", "a\nb", "\x1b[2J", "\0", "[/red]", "trap:make", "0" * 64, "\u202e", "rule-4",
    [], {}, [[]], [None], {"": 0}, {"a\nb": "c"},
)  # fmt: skip
DTYPES = ("F64", "F32", "F16", "BF16", "I64", "I8", "U16", "BOOL", "F8_E4M3", "F4", "C64", "X9", "")
LENGTHS = (0, 1, 2**20, 2**31, 2**63, 2**64 - 1)


def require_one_line(text: str) -> None:
    """Assert that a message is one line that can be printed."""
    assert len(text.splitlines()) == 1, text
    assert text.isprintable(), text


def change_json(text: bytes, rng: Rng) -> bytes:
    """Return JSON with one to three of its parts changed, and now and then broken."""
    data = json.loads(text)
    for _ in range(rng.integers(1, 4)):
        data = _change(data, rng)
    changed = json.dumps(data).replace('"HUGE"', "9" * 5000).encode()
    chance = rng.random()
    if chance < 0.05:
        return _nested(changed, rng)
    if chance < 0.1:
        return _twice(changed, rng)
    return change_bytes(changed, rng) if chance < 0.2 else changed


def change_bytes(data: bytes, rng: Rng) -> bytes:
    """Return bytes with some of them flipped, cut off, taken out, put in or doubled."""
    cut = int(rng.integers(len(data) + 1))
    end = min(len(data), cut + int(rng.integers(1, 40)))
    match int(rng.integers(5)):
        case 0:
            flipped = np.frombuffer(data, np.uint8).copy()
            flipped[rng.integers(len(data), size=rng.integers(1, 6))] ^= np.uint8(1 << int(rng.integers(8)))
            return flipped.tobytes()
        case 1:
            return data[:cut]
        case 2:
            return data[:cut] + data[end:]
        case 3:
            return data[:cut] + rng.bytes(int(rng.integers(1, 9))) + data[cut:]
        case _:
            return data[:end] + data[cut:]


def change_tensors(data: bytes, rng: Rng, key: str) -> bytes:
    """Return a safetensors file with its bytes, its header, or the JSON ``key`` of its metadata changed."""
    if rng.random() < 0.2:
        return change_bytes(data, rng)
    length = int.from_bytes(data[:8], "little")
    header, rest = json.loads(data[8 : 8 + length]), data[8 + length :]
    if rng.random() < 0.6:
        metadata = header["__metadata__"]
        metadata[key] = change_json(metadata[key].encode(), rng).decode(errors="replace")
    else:
        header = _change_header(header, rng)
    spelt = json.dumps(header).encode()
    length = len(spelt) if rng.random() < 0.95 else int(rng.choice(np.array(LENGTHS, np.uint64)))
    return struct.pack("<Q", length) + spelt + rest


def change_arrays(content: bytes, rng: Rng) -> bytes:
    """Return a safetensors file changed, its bytes or what it says of an array."""
    if rng.random() < 0.3:
        return change_bytes(content, rng)
    length = int.from_bytes(content[:8], "little")
    header = _change_header(json.loads(content[8 : 8 + length]), rng)
    spelt = json.dumps(header).encode()
    return struct.pack("<Q", len(spelt)) + spelt + content[8 + length :]


def change_lines(text: bytes, rng: Rng) -> bytes:
    """Return lines of JSON with one of them changed, taken out or doubled."""
    lines = text.splitlines(keepends=True)
    place = int(rng.integers(len(lines)))
    line = lines[place]
    lines[place : place + 1] = [[change_json(line, rng), b"\n"], [], [line, line]][
        int(rng.choice(3, p=[0.8, 0.1, 0.1]))
    ]
    return b"".join(lines)


def agent_name(rng: Rng) -> str:
    """Return what nobody should call an agent."""
    alphabet = [*"ab:./\\~-_ \n\t\0\x1b[]{}%$'\"", "..", "\ud800", "\u202e", "seed", "x" * 300, "rule", "é"]
    return "no_" * bool(rng.random() < 0.5) + "".join(rng.choice(alphabet, size=rng.integers(0, 9)))


def _change(data: Any, rng: Rng) -> Any:
    place = _place(data, rng)
    if rng.random() < 0.5:
        leaf = at(data, place)
        return data if isinstance(leaf, dict | list) else put(data, place, other(leaf, rng))
    match int(rng.integers(5)):
        case 0 | 1:
            return put(data, place, VALUES[rng.integers(len(VALUES))])
        case 2:
            return put(data, place, at(data, _place(data, rng)))
        case 3:
            return _without(data, place)
        case _:
            return _with_more(data, place, rng)


def _place(data: Any, rng: Rng) -> Place:
    """Return the place of a leaf, or of something that holds it."""
    places = list(leaves(data))
    if not places:
        return ()
    place = places[rng.integers(len(places))]
    return place[: rng.integers(len(place) + 1)] if rng.random() < 0.3 else place


def _without(data: Any, place: Place) -> Any:
    if not place:
        return {}
    holder = at(data, place[:-1])
    if isinstance(holder, dict):
        return put(data, place[:-1], {key: value for key, value in holder.items() if key != place[-1]})
    return put(data, place[:-1], [value for index, value in enumerate(holder) if index != place[-1]])


def _with_more(data: Any, place: Place, rng: Rng) -> Any:
    if not place:
        return [data]
    holder, value = at(data, place[:-1]), VALUES[rng.integers(len(VALUES))]
    if isinstance(holder, dict):
        name = str(VALUES[rng.integers(len(VALUES) - 5)])[:500] if rng.random() < 0.5 else f"{place[-1]}_"
        return put(data, place[:-1], holder | {name: value})
    return put(data, place[:-1], [*holder, at(data, place) if rng.random() < 0.5 else value])


def _change_header(header: dict[str, Any], rng: Rng) -> Any:
    """Return the header of a safetensors file with the type, the shape or the place of an array changed."""
    name = str(rng.choice([key for key in header if key != "__metadata__"]))
    own = dict(header[name])
    match int(rng.integers(5)):
        case 0:
            own["dtype"] = str(rng.choice(DTYPES))
        case 1:
            own["shape"] = [*own["shape"][::-1], *([1] if rng.random() < 0.5 else [])]
        case 2:
            own["shape"] = [int(size) for size in rng.choice([0, 1, 2, 2**31, 2**62], size=rng.integers(0, 4))]
        case 3:
            own["data_offsets"] = sorted(int(end) for end in rng.choice([0, 1, 4, 100, 2**40, 2**62], size=2))
        case _:
            return _change(header, rng)
    return header | {name: own}


def _nested(text: bytes, rng: Rng) -> bytes:
    """Return JSON with a number replaced by lists in lists in lists."""
    depth, place = int(rng.choice([150, 900, 100_000])), text.find(b": ", int(rng.integers(len(text))))
    return text if place < 0 else text[: place + 2] + b"[" * depth + b"]" * depth + b", " + text[place + 2 :]


def _twice(text: bytes, rng: Rng) -> bytes:
    """Return JSON with a name given twice."""
    place = text.find(b', "', int(rng.integers(len(text))))
    end = text.find(b":", place)
    return text if place < 0 or end < 0 else text[:end] + b": 0" + text[place:]
