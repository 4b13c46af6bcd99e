"""Which files of a folder of published entries are entries: every reader of one asks here."""

import re
from pathlib import Path
from types import MappingProxyType
from typing import Annotated

from pydantic import StringConstraints

from hhrl_bench.errors import RecordError
from hhrl_bench.schema import RESERVED, STEM

INDEX, SCHEMA = "INDEX.json", "schema.json"
NO_ENTRIES = MappingProxyType({INDEX: "the index", SCHEMA: "the schema"})
"""The JSON files beside the entries, and what they are."""

EntryFileName = Annotated[str, StringConstraints(pattern=rf"^{STEM}\.json$")]


def is_entry_name(name: str) -> bool:
    """Return whether a name, which is that of its file without ``.json``, can be an entry's."""
    return re.fullmatch(STEM, name) is not None and name not in RESERVED


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
