"""The hash of a scenario's data, which stays what it was when fields are added."""

import hashlib
import json
from dataclasses import fields, is_dataclass
from operator import methodcaller
from typing import Any

ADDITION = {"addition": True}
"""The metadata of a field that counts in the hash only where it differs from its default.

What a scenario was before there was the field, it is with the default; so it keeps its hash.
"""


def counted(data: Any) -> Any:
    """Return the data of a dataclass, field by field, without the additions that have their defaults."""
    if isinstance(data, tuple):
        return [counted(one) for one in data]
    if not is_dataclass(data):
        return data
    values = {one: getattr(data, one.name) for one in fields(data)}
    return {
        one.name: counted(value) for one, value in values.items() if one.metadata != ADDITION or value != one.default
    }


def digest(data: object) -> str:
    """Return the SHA-256 of the data as JSON; numbers of numpy count as Python's."""
    stored = json.dumps(data, sort_keys=True, allow_nan=False, default=methodcaller("item"))
    return hashlib.sha256(stored.encode()).hexdigest()
