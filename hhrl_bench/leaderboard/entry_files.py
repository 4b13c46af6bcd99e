"""Which files of a folder of published entries are entries: every reader of one asks here."""

import re
from pathlib import Path
from types import MappingProxyType
from typing import Annotated

from pydantic import StringConstraints

from hhrl_bench.errors import RecordError

INDEX, SCHEMA = "INDEX.json", "schema.json"
NO_ENTRIES = MappingProxyType({INDEX: "the index", SCHEMA: "the schema"})
"""The JSON files beside the entries, and what they are."""

_NAME = "[a-z0-9][a-z0-9-]{0,60}"

EntryFileName = Annotated[str, StringConstraints(pattern=rf"^{_NAME}\.json$")]


def is_entry_name(name: str) -> bool:
    """Return whether a name, which is that of its file without ``.json``, can be an entry's."""
    return re.fullmatch(_NAME, name) is not None and f"{name}.json" not in NO_ENTRIES


def find_entries(folder: Path) -> list[Path]:
    """Return the paths of the entries in a folder, by name.

    Raises:
        RecordError: if it holds a JSON file that is not hidden, and named neither as an entry nor as those beside them.
    """
    found = (path for path in folder.glob("*.json") if not path.name.startswith("."))
    paths = sorted(path for path in found if path.name not in NO_ENTRIES)
    for path in paths:
        if not is_entry_name(path.stem):
            raise RecordError(
                f"{path} is not named as an entry; write small letters, digits and hyphens, or keep it elsewhere"
            )
    return paths


def entry_paths(folder: Path) -> list[Path]:
    """Return the same of a folder that has to hold an entry.

    Raises:
        RecordError: if it has none too.
    """
    paths = find_entries(folder)
    if not paths:
        raise RecordError(f"{folder} holds no entry; hhrl-bench run writes one")
    return paths
