"""Extensions: modules of users that register metrics, scenarios and more of their own, loaded before a command runs.

A scenario file, which runs no code, is an extension that registers its scenario.
"""

import contextlib
import hashlib
import importlib
import os
import sys
from collections.abc import Sequence
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from traceback import extract_tb
from types import ModuleType

from hhrl_envs import read_scenario
from hhrl_envs.errors import InputError
from hhrl_envs.scenario.registry import add_scenario

VARIABLE = "HHRL_EXTENSIONS"
"""The environment variable that names extensions, separated by ``os.pathsep``; processes of a sweep inherit it."""

_hashes: dict[str, str] = {}


def load_extensions(given: Sequence[str] = ()) -> None:
    """Load the extensions that the environment names, then the given ones, each once, and name all in the environment.

    Args:
        given: modules, as in an import statement and also looked for in the current folder, or files: ``.py``, or
            ``.json`` of a scenario.

    Raises:
        InputError: if one cannot be loaded.
    """
    known = [name for name in os.environ.get(VARIABLE, "").split(os.pathsep) if name]
    names = [str(Path(name).resolve()) if _is_file(name) else name for name in (*known, *given)]
    for name in names:
        try:
            file = _load(name)
        except (Exception, SystemExit) as error:
            raise InputError(f"cannot load the extension {name!r}: {_reason(error, name)}") from error
        if name not in _hashes:
            _hashes[name] = _hash(file)
    if given:
        os.environ[VARIABLE] = os.pathsep.join(dict.fromkeys(names))


def extension_hashes() -> list[str]:
    """Return the sha256 of the file of every extension that was loaded, as it was then, in the order of their names."""
    return [_hashes[name] for name in sorted(_hashes)]


def import_here(module: str, folder: Path | None = None) -> ModuleType:
    """Return a module, looked for in a folder too, by default the current one; what it prints goes to stderr."""
    here = str(folder or Path.cwd())
    if here not in sys.path:
        sys.path.insert(0, here)
    with contextlib.redirect_stdout(sys.stderr):
        return importlib.import_module(module)


def _reason(error: BaseException, name: str) -> str:
    """Return why an extension could not be loaded: what is wrong in it and where, or that there is no such thing."""
    if name.endswith(".json"):
        return str(error)
    why = str(error) if isinstance(error, InputError) else f"{type(error).__name__}: {error}"
    lines = [frame for frame in extract_tb(error.__traceback__) if Path(frame.filename).stem == Path(name).stem]
    if lines:
        return f"{why} ({Path(lines[-1].filename).name}, line {lines[-1].lineno})"
    return f"{why}; name a module, as in an import statement, or a file that ends in .py"


def _is_file(name: str) -> bool:
    return name.endswith((".py", ".json"))


def _load(name: str) -> Path | None:
    """Load an extension, and return its file if it has one."""
    if name.endswith(".json"):
        add_scenario(read_scenario(name))
        return Path(name)
    return _file_of(_load_file(Path(name)) if _is_file(name) else import_here(name))


def _load_file(path: Path) -> ModuleType:
    """Return the module in a file, under the name of the file if no other module has it."""
    name = path.stem
    if name in sys.modules and _file_of(sys.modules[name]) != path:
        name = f"{name}_{hashlib.sha256(str(path).encode()).hexdigest()[:8]}"
    if name in sys.modules:
        return sys.modules[name]
    spec = spec_from_file_location(name, path)
    if spec is None or spec.loader is None or not path.is_file():
        raise FileNotFoundError(f"there is no file {path}")
    module = sys.modules[name] = module_from_spec(spec)
    try:
        with contextlib.redirect_stdout(sys.stderr):
            spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    return module


def _file_of(module: ModuleType) -> Path | None:
    file = getattr(module, "__file__", None)
    return None if file is None else Path(file).resolve()


def _hash(file: Path | None) -> str:
    return hashlib.sha256(file.read_bytes() if file and file.is_file() else b"").hexdigest()
