"""What pyproject.toml asks for, and the versions that were tested."""

import tomllib
from pathlib import Path
from typing import Any

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[2]
PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def dependencies(*extras: str) -> list[Requirement]:
    """Return what the project asks for with these extras, and with those that they name."""
    lines = [*PROJECT["dependencies"], *(line for extra in extras for line in PROJECT["optional-dependencies"][extra])]
    found = list(map(Requirement, lines))
    own = [requirement for requirement in found if requirement.name == PROJECT["name"]]
    return [
        *(requirement for requirement in found if requirement not in own),
        *(inner for requirement in own for inner in dependencies(*requirement.extras)),
    ]


def constraints() -> dict[str, str]:
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    pairs = (line.split("==") for line in lines if line and not line.startswith("#"))
    return {canonicalize_name(name): version for name, version in pairs}
