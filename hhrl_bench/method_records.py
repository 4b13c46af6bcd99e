"""What runs were trained by, as a record."""

from collections.abc import Iterable, Mapping
from typing import Any

from pydantic import JsonValue, ValidationError

from hhrl_bench.errors import RecordError
from hhrl_bench.records import Name, Record, first_problem


class MethodRecord(Record):
    """A method: all of its settings, and their hash."""

    id: Name
    config_hash: Name
    config: dict[str, JsonValue]


def method_records(metadata: Iterable[Mapping[str, Any]]) -> tuple[MethodRecord, ...]:
    """Return the methods that checkpoints with these metadata were trained by, each once, in their order.

    Raises:
        RecordError: if the metadata do not say so.
    """
    return tuple({record.config_hash: record for record in map(_record, metadata)}.values())


def _record(metadata: Mapping[str, Any]) -> MethodRecord:
    given = {"id": metadata.get("method"), **{key: metadata.get(key) for key in ("config_hash", "config")}}
    try:
        return MethodRecord.model_validate(given)
    except ValidationError as error:
        raise RecordError(f"a checkpoint says of its method what cannot be: {first_problem(error)}") from error
