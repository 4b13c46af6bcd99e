"""The index of published entries, as a record."""

from typing import Annotated, Literal

from pydantic import Field, StringConstraints

from hhrl_bench.level import Level
from hhrl_bench.records import Name, Positive, Record, Sha256

FileName = Annotated[str, StringConstraints(pattern=r"^[a-z0-9][a-z0-9-]{0,60}\.json$")]
Day = Annotated[str, StringConstraints(pattern=r"^[0-9]{4}-[0-9]{2}-[0-9]{2}$")]


class VerifiedRecord(Record):
    """How far an entry was verified, when, and by which version of this package."""

    level: Level = Field(strict=False)
    day: Day
    package_version: Name


class EntryRecord(Record):
    """An entry: its file, what is in it, and how far it was verified. It is a submission if not named by its suite."""

    file: FileName
    sha256: Sha256
    suite: Name
    tasks: tuple[Name, ...]
    agents: tuple[Name, ...]
    results: Positive
    verified: VerifiedRecord


class IndexRecord(Record):
    """All entries in a folder, by file name."""

    schema_version: Literal[1]
    entries: tuple[EntryRecord, ...]
