"""What the records of all files share: types of fields, strictness, and what is said of a wrong one, in one line."""

import hashlib
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, StringConstraints, ValidationError

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
Name = Annotated[str, StringConstraints(min_length=1, max_length=500, pattern=r"^[^\x00-\x1f\x7f-\x9f]*$")]
"""No name holds a control character, which might be a line end, or a command to a terminal."""
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
