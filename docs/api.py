"""Write the API documentation, one page a module from its docstrings: ``python docs/api.py site``."""

import importlib
import pkgutil
import sys
import warnings
from pathlib import Path

import pdoc

PACKAGES = ("hhrl_envs", "hhrl_agents", "hhrl_bench")


def modules(package: str) -> list[str]:
    """Return the names of a package and of its modules; ``__main__`` would run the command line."""
    found = pkgutil.iter_modules(importlib.import_module(package).__path__)
    return [package, *(f"{package}.{module.name}" for module in found if module.name != "__main__")]


def publish(package: str) -> None:
    """Return nothing; make a package's modules, and what it imports when asked for, visible to pdoc."""
    module = importlib.import_module(package)
    exported = [*module.__all__, *(name.partition(".")[2] for name in modules(package)[1:])]
    vars(module).update({name: getattr(module, name) for name in module.__all__}, __all__=list(dict.fromkeys(exported)))


def build(folder: Path) -> None:
    """Return nothing; write a page for every module of the packages. A warning of pdoc's is an error."""
    warnings.simplefilter("error")
    pdoc.render.configure(docformat="google", show_source=False)
    for package in PACKAGES:
        publish(package)
    pdoc.pdoc(*PACKAGES, output_directory=folder)


if __name__ == "__main__":
    build(Path(sys.argv[1]))
