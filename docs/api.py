"""Write the API documentation, one page a module from its docstrings: ``python docs/api.py site``."""

import importlib
import pkgutil
import sys
import warnings
from pathlib import Path

import pdoc

PACKAGES = ("hhrl_envs", "hhrl_agents", "hhrl_bench")


def modules(package: str) -> list[str]:
    """Return the names of a package and of the modules and folders in it; ``__main__`` would run the command line."""
    found = pkgutil.iter_modules(importlib.import_module(package).__path__)
    return [package, *(f"{package}.{module.name}" for module in found if module.name != "__main__")]


def publish(package: str) -> None:
    """Make what lies in a package, and what it imports when asked for, visible to pdoc; so with the folders in it."""
    module, inside = importlib.import_module(package), modules(package)[1:]
    if exported := getattr(module, "__all__", None):
        names = [*exported, *(name.removeprefix(f"{package}.") for name in inside)]
        vars(module).update({name: getattr(module, name) for name in exported}, __all__=list(dict.fromkeys(names)))
    for name in inside:
        if hasattr(importlib.import_module(name), "__path__"):
            publish(name)


def build(folder: Path) -> None:
    """Write a page for every module of the packages. A warning of pdoc's is an error."""
    warnings.simplefilter("error")
    pdoc.render.configure(docformat="google", show_source=False)
    for package in PACKAGES:
        publish(package)
    pdoc.pdoc(*PACKAGES, output_directory=folder)


if __name__ == "__main__":
    build(Path(sys.argv[1]))
