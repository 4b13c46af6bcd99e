"""What runs were trained by, as a record."""

from collections.abc import Iterable, Mapping
from typing import Any

from pydantic import JsonValue

from hhrl_bench.records import Name, Record


class MethodRecord(Record):
    """A method: all of its settings, and their hash."""

    id: Name
    config_hash: Name
    config: dict[str, JsonValue]


def method_records(metadata: Iterable[Mapping[str, Any]]) -> tuple[MethodRecord, ...]:
    """Return the methods that checkpoints with these metadata were trained by, each once, in their order."""
    found = {
        data["config_hash"]: MethodRecord(id=data["method"], config_hash=data["config_hash"], config=data["config"])
        for data in metadata
    }
    return tuple(found.values())
