"""What the records of all files share: types of fields, strictness, and what is said of a wrong one, in one line."""

import hashlib
import json
import math
import unicodedata
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Final, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, FailFast, Field, StringConstraints, ValidationError

from hhrl_envs import SUB_GOALS, Outcome
from hhrl_envs.errors import one_line


def finite(numbers: Mapping[str, float]) -> dict[str, float | None]:
    """Return the numbers with None, which JSON can say, in place of NaN and infinities."""
    return {key: value if math.isfinite(value) else None for key, value in numbers.items()}


SCHEMA_VERSION: Final = 1

Finite = Annotated[float, Field(allow_inf_nan=False)]
Rate = Annotated[float, Field(allow_inf_nan=False, ge=0.0, le=1.0)]
Count = Annotated[int, Field(ge=0, le=2**53)]
Positive = Annotated[int, Field(ge=1, le=2**53)]
Sha256 = Annotated[str, StringConstraints(pattern=r"^[0-9a-f]{64}$")]
Commit = Annotated[str, StringConstraints(pattern=r"^[0-9a-f]{40}(-dirty)?$")]


def _shown(text: str) -> str:
    """Return a text of which every sign is shown, and is spelled in one way; refuse any other."""
    hidden = next((sign for sign in text if unicodedata.category(sign)[0] == "C" or sign in _LINE_ENDS), None)
    if hidden is not None:
        raise ValueError(f"write it without the sign U+{ord(hidden):04X}, which is not shown")
    if not unicodedata.is_normalized("NFC", text):
        raise ValueError("write it in the normal form NFC")
    return text


_LINE_ENDS = "\N{LINE SEPARATOR}\N{PARAGRAPH SEPARATOR}"
_SHOWN = r"^[^\x00-\x1f\x7f-\x9f]*$"
Name = Annotated[str, StringConstraints(min_length=1, max_length=500, pattern=_SHOWN), AfterValidator(_shown)]
"""No name holds a sign that might be a line end, a command to a terminal, or turn the order of others."""

Label = Annotated[str, StringConstraints(max_length=1100, pattern=_SHOWN), AfterValidator(_shown)]
"""The same, or nothing, or two names together."""

STEM = r"[a-z0-9][a-z0-9-]{0,60}"
"""How what an entry or a suite is called is spelled: it is the name of files."""

RESERVED = ("index", "readme", "schema")
"""Files of a folder of entries that are none of a suite, whatever the case of their letters."""


def _free(stem: str) -> str:
    if stem in RESERVED:
        raise ValueError(f"write another name than {stem}, which is that of another file")
    return stem


Stem = Annotated[str, StringConstraints(pattern=f"^{STEM}$"), AfterValidator(_free)]
"""The name of a suite, under which files are written."""

MAX_RESULTS = 500
"""Results of an entry, and arms of a transfer."""

MAX_SEEDS = 100
"""Training seeds of a result or a learning curve."""

MAX_REPORTS = 10_000
"""Reports of a learning curve."""

MAX_KEYS = 1000
"""Names in an object of JSON."""

MAX_BRACKETS = 200_000
"""Lists and objects in a file of JSON, most of which are far larger in memory than in the file."""

FIRST = FailFast()
"""Of the items of a list, only the first one that is wrong is told: a file may hold millions of them."""


def require_plain(data: bytes) -> None:
    """Raise a ``ValueError`` unless some content is JSON in which no object has more than MAX_KEYS names, each once.

    What is wrong with every name of an object is told, so there must not be millions of them; nor of lists and objects,
    of which it has at most MAX_BRACKETS.
    """
    if (brackets := data.count(b"[") + data.count(b"{")) > MAX_BRACKETS:
        raise ValueError(f"it has {brackets:,} lists and objects; write at most {MAX_BRACKETS:,}")
    try:
        json.loads(data.decode(), object_pairs_hook=_require_few)
    except RecursionError as error:
        raise ValueError("it is nested too deep") from error


def _require_few(pairs: list[tuple[str, object]]) -> None:
    if len(pairs) > MAX_KEYS:
        raise ValueError(f"an object has {len(pairs):,} names; write at most {MAX_KEYS:,}")
    if len(dict(pairs)) < len(pairs):
        raise ValueError("an object has a name twice; keep one")


if TYPE_CHECKING:
    OptionName = str
    OutcomeName = str
else:
    OptionName = Literal[tuple(goal.name for goal in SUB_GOALS)]
    OutcomeName = Literal[tuple(outcome.name.lower() for outcome in Outcome if outcome != Outcome.RUNNING)]


class Record(BaseModel):
    """What all records share: unknown keys, wrong types and changes are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


def first_problem(error: ValidationError) -> str:
    """Return, in one line, where a record is wrong first, and what is wrong there."""
    problems = error.errors(include_url=False, include_input=False, include_context=False)
    where = one_line(".".join(str(part) for part in problems[0]["loc"]))
    said = problems[0]["msg"]
    for theirs, ours in _WORDING.items():
        said = said.replace(theirs, ours, 1)
    more = f" (and {len(problems) - 1} more)" if len(problems) > 1 else ""
    return f"{where + ': ' if where else ''}{said}{more}"


_WORDING = {
    "Value error, ": "",
    "Field required": "is missing; add it",
    "Extra inputs are not permitted": "is not known; leave it out",
    "Input should be less": "write a number less",
    "Input should be greater": "write a number greater",
    "Input should be ": "write ",
    "String should have ": "write a string with ",
    "String should match ": "write a string that matches ",
    "Tuple should have ": "write a list with ",
    "Invalid JSON: ": "this is no JSON: ",
}
"""What is said in place of pydantic's words."""


def sha256_of(data: bytes) -> str:
    """Return the sha256 of some content, in hex."""
    return hashlib.sha256(data).hexdigest()
