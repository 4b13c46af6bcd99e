"""What the name of an agent stands for, before anything is loaded: shipped seeds, files of policies, own factories."""

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

from hhrl_agents import METHODS, ORACLES, RULES
from hhrl_agents.adapters.files import ENDINGS
from hhrl_agents.policies.checkpoint_file import SHIPPED
from hhrl_bench.errors import AgentError
from hhrl_bench.schema import MAX_SEEDS
from hhrl_bench.tasks.seeds import format_seeds, parse_seeds

One = TypeVar("One")

_SEEDS = re.compile(r"(.+):([0-9][0-9,-]*)")


def shipped_methods() -> dict[str, int]:
    """Return how many trained seeds come with the package, for every method that has some."""
    counts = {method: len(_checkpoints(SHIPPED / method)) for method in METHODS}
    return {method: count for method, count in counts.items() if count}


def named_seeds(name: str) -> tuple[str, tuple[int, ...]] | None:
    """Return the method and the training seeds of a name such as ``hybrid-hrl:3`` or ``ddqn:0-2``; else None.

    Raises:
        SeedError: if the seeds are spelled otherwise.
    """
    match = _SEEDS.fullmatch(name)
    return (match[1], parse_seeds(match[2])) if match and match[1] in METHODS else None


def is_registered(name: str) -> bool:
    """Return whether a name is that of a registered agent, with training seeds behind it or without."""
    return name in {*RULES, *ORACLES, *METHODS} or named_seeds(name) is not None


def shipped_checkpoints(name: str) -> list[Path]:
    """Return the checkpoints that come with the package and that a method, or seeds of one, name; none for others.

    Raises:
        AgentError: if they do not come with the package.
    """
    method, seeds = named_seeds(name) or (name, None)
    if method not in METHODS:
        return []
    paths = _checkpoints(SHIPPED / method)
    if not paths:
        said = f"no trained {method} comes with the package; train it: hhrl-bench train {method}"
        raise AgentError(f"{said}; for what lies here write ./{name}" if Path(name).exists() else said)
    by_seed = {int(path.stem.removeprefix("seed-")): path for path in paths}
    missing = sorted(set(seeds or ()) - by_seed.keys())
    if missing:
        raise AgentError(
            f"no seed {missing[0]} of {method} comes with the package; write seeds of {format_seeds(sorted(by_seed))}"
        )
    return [by_seed[seed] for seed in seeds or sorted(by_seed)]


def policy_files(name: str) -> list[Path]:
    """Return the files of policies that a path, a folder, or paths with commas between them name; none for others.

    In a folder these are the chosen checkpoints of a training, else all files of another library, in the order of the
    numbers in their names.

    Raises:
        AgentError: if a folder holds none, or a list names a file twice, one that is not there, or several kinds.
    """
    path = Path(name)
    if name and _holds(path.is_dir):
        return _in_folder(path)
    if _is_policy(path):
        return [path]
    paths = [Path(part) for part in name.split(",")]
    there = [one for one in paths if _is_policy(one)]
    if len(paths) == 1 or not there:
        return []
    missing = next((one for one in paths if one not in there), None)
    if missing is not None:
        raise AgentError(f"{name!r} lists {missing}, which is not there; list files of policies, with commas between")
    if len(set(paths)) < len(paths):
        raise AgentError(f"{name!r} lists a file twice; list each training seed's once")
    return _of_one_kind(name, paths)


def runs_apart(name: str) -> list[str]:
    """Return what makes the agents that run in processes of their own, one a training seed; none for other agents.

    Each is the path of a file of another library, ``module:factory``, or ``module:factory@SEED``.

    Raises:
        InputError: as ``policy_files``; or if the seeds behind an ``@`` are spelled otherwise, or are too many.
    """
    if is_registered(name):
        return []
    paths = policy_files(name)
    if paths or ":" not in name:
        return [str(path.resolve()) for path in paths if path.suffix in ENDINGS]
    factory, at, seeds = name.partition("@")
    return [f"{factory}@{seed}" for seed in _few(parse_seeds(seeds), name)] if at else [name]


def own_seeds(sources: Sequence[str]) -> list[int | None]:
    """Return the training seeds of what makes agents in processes of their own: the last numbers in their names.

    They are the places 0, 1, 2, ... where the names do not tell them apart; a single one without ``@`` has none.
    """
    if len(sources) == 1 and "@" not in sources[0]:
        return [None]
    numbers = [re.findall(r"[0-9]+", Path(source).stem) for source in sources]
    seeds = [int(found[-1][-9:]) for found in numbers if found]
    return [*(seeds if len(set(seeds)) == len(sources) else range(len(sources)))]


def names_file(source: str) -> bool:
    """Return whether what makes an agent in a process of its own is a file."""
    return Path(source).suffix in ENDINGS


def _in_folder(folder: Path) -> list[Path]:
    paths = _checkpoints(folder) or sorted((one for one in folder.iterdir() if one.suffix in ENDINGS), key=_by_number)
    if not paths:
        endings = ", ".join(f"*{ending}" for ending in ENDINGS)
        raise AgentError(
            f"{folder} holds no seed-<k>.safetensors, nor {endings}; name a folder that hhrl-bench train has filled, "
            "or one with the files of another library's training seeds"
        )
    return _of_one_kind(str(folder), paths)


def _of_one_kind(name: str, paths: list[Path]) -> list[Path]:
    kinds = sorted({path.suffix for path in paths})
    if len(kinds) > 1:
        raise AgentError(f"{name!r} holds files of several kinds, {', '.join(kinds)}; name files of one of them")
    return _few(paths, name)


def _few(ones: Sequence[One], name: str) -> list[One]:
    if len(ones) > MAX_SEEDS:
        raise AgentError(f"{name!r} has {len(ones)} training seeds; name at most {MAX_SEEDS}")
    return list(ones)


def _checkpoints(folder: Path) -> list[Path]:
    """Return the chosen checkpoints in a folder, lowest seed first."""
    named = ((re.fullmatch(r"seed-([0-9]{1,9})\.safetensors", path.name), path) for path in folder.glob("seed-*"))
    return [path for _, path in sorted((int(match[1]), path) for match, path in named if match)]


def _by_number(path: Path) -> list[tuple[bool, int, str]]:
    """Return what sorts names by the numbers in them."""
    pieces = re.findall(r"([0-9]+)|([^0-9]+)", path.stem)
    return [(bool(text), int(number or 0), text) for number, text in pieces]


def _is_policy(path: Path) -> bool:
    return path.suffix != ".py" and _holds(path.is_file)


def _holds(check: Callable[[], bool]) -> bool:
    try:
        return check()
    except OSError:  # a name that is too long for a file, or a folder that must not be looked into
        return False
