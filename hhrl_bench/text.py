"""Names of agents and tasks, which may be paths or module:factory, made to fit into narrow columns and file names."""

import re
from collections.abc import Iterable
from difflib import get_close_matches
from hashlib import sha256

NAME_WIDTH = 24
"""Letters of a line, where there is room."""

PLAIN_WIDTH = 160
"""Letters of a line that is wide enough for any table, where nobody says how wide lines are."""

LONGEST_FILE_NAME = 100
"""Letters of a file's name."""

NONE = "\N{EN DASH}"
"""What stands where there is no number."""

_PIECE = re.compile(r"[^-/:._ ]*[-/:._ ]?")


def folded(name: str, width: int = NAME_WIDTH) -> str:
    """Return a name in lines of at most ``width`` letters, broken behind punctuation; only longer pieces are cut."""
    lines = [""]
    for piece in _pieces(name, width):
        if len((lines[-1] + piece).rstrip()) > width:
            lines.append("")
        lines[-1] += piece
    return "\n".join(line.rstrip() for line in lines)


def indented(name: str, width: int = NAME_WIDTH) -> str:
    """Return a name folded, every line below the heading of its group."""
    return "\n".join(f"  {line}" for line in folded(name, width).splitlines())


def meant(name: str, known: Iterable[str]) -> str:
    """Return the question whether a known name was meant that is nearly this one; nothing if none is near."""
    near = get_close_matches(name.replace("_", "-"), list(known), n=1)
    return f", did you mean {near[0]}" if near else ""


_ALIKE = str.maketrans("01i|592346g78", "ollls" + "qzeabqtb")
_ALIKE_PAIRS = {"cl": "d", "rn": "m", "vv": "w"}


def look(name: str) -> str:
    """Return the letters and digits of a name, the same for those that look alike: equal for names easily mistaken."""
    letters = "".join(filter(str.isalnum, name.casefold().translate(_ALIKE)))
    for pair, one in _ALIKE_PAIRS.items():
        letters = letters.replace(pair, one)
    return letters


def looks_like(name: str, known: Iterable[str]) -> str | None:
    """Return which of the known names a name looks like, by its letters and digits; None: like none of them."""
    return {look(one): one for one in known}.get(look(name))


def file_name(name: str) -> str:
    """Return a name that any folder can hold and that lies in no other; different names have different ones."""
    plain = re.sub(r"[^A-Za-z0-9_-]", "_", name)
    if plain == name and len(name) <= LONGEST_FILE_NAME:
        return plain
    return f"{plain[-60:]}-{sha256(name.encode()).hexdigest()[:8]}"


def _pieces(name: str, width: int) -> list[str]:
    pieces = _PIECE.findall(" ".join(name.split()))
    return [piece[start : start + width] for piece in pieces for start in range(0, len(piece), width)]
