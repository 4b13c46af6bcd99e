"""Compiled kernels are kept where nobody else can write, and compiled anew if sources have changed or a file is cut."""

import importlib
import os
import pickle
import shutil
import stat
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import pytest

import hhrl_envs
from hhrl_envs.simulation.engine.kernel_cache import _SAID, digest_sources

PACKAGE = Path(hhrl_envs.__file__).parent


@pytest.fixture
def copied(tmp_path: Path) -> Path:
    return Path(shutil.copytree(PACKAGE, tmp_path / "hhrl_envs", ignore=shutil.ignore_patterns("__pycache__")))


@pytest.mark.parametrize(
    "changed",
    [
        "sub_goals.py",
        "scenario/profiles.py",
        "simulation/dynamics.py",
        "simulation/sub_goal_kernels.py",
        "simulation/engine/layout.py",
    ],
)
def test_a_changed_source_of_kernels_changes_their_digest(copied: Path, changed: str) -> None:
    assert digest_sources(copied) == digest_sources(PACKAGE)
    source = copied / changed
    source.write_text(source.read_text() + "\n")
    assert digest_sources(copied) != digest_sources(PACKAGE)


def test_a_source_without_kernels_does_not_count(copied: Path) -> None:
    source = copied / "rendering" / "picture.py"
    source.write_text(source.read_text() + "\n")
    assert digest_sources(copied) == digest_sources(PACKAGE)


KERNEL = """
from hhrl_envs.simulation.engine.compilation import kernel


@kernel
def more(number):
    return number + {step}
"""


class Poison:
    """Makes a folder when it is unpickled."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def __reduce__(self) -> tuple[object, tuple[str]]:
        return os.mkdir, (str(self._folder),)


@pytest.fixture
def imported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[], Any]:
    """Return what imports a package with one kernel as a new process would; the kernel is kept in ``tmp_path/kept``."""
    package = tmp_path / "little"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "kernels.py").write_text(KERNEL.format(step=1))
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "kept"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home"))
    monkeypatch.setenv(_SAID, "")
    monkeypatch.delenv(_SAID)

    def load() -> Any:
        for name in ("little", "little.kernels"):
            monkeypatch.delitem(sys.modules, name, raising=False)
        return importlib.import_module("little.kernels").more

    return load


def kept(folder: Path, kind: str = "*") -> list[Path]:
    return sorted(folder.glob(f"kept/*/*.{kind}"))


def test_a_later_process_reads_what_was_kept(imported: Callable[[], Any], tmp_path: Path) -> None:
    assert imported()(1) == 2
    assert {path.suffix for path in kept(tmp_path)} == {".nbi", ".nbc"}
    assert all(stat.S_IMODE(path.parent.stat().st_mode) == 0o700 for path in kept(tmp_path))
    again = imported()
    assert again(1) == 2
    assert again.stats.cache_hits.total() == 1


@pytest.mark.parametrize("kind", ["nbi", "nbc"])
@pytest.mark.parametrize("left", [0, 100])
def test_an_entry_that_was_cut_short_is_compiled_and_kept_again(
    kind: str, left: int, imported: Callable[[], Any], tmp_path: Path
) -> None:
    imported()(1)
    (entry,) = kept(tmp_path, kind)
    entry.write_bytes(entry.read_bytes()[:left])
    assert imported()(1) == 2
    again = imported()
    assert again(1) == 2
    assert again.stats.cache_hits.total() == 1


@pytest.mark.skipif(os.name != "posix", reason="folders have no such modes")
def test_a_folder_where_others_can_write_is_not_read(
    imported: Callable[[], Any], tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    imported()(1)
    for entry in kept(tmp_path):
        entry.write_bytes(pickle.dumps(numba.__version__) + pickle.dumps(Poison(tmp_path / "poisoned")))
        entry.parent.chmod(0o770)
    assert imported()(1) == 2
    assert not (tmp_path / "poisoned").exists()
    assert len(caplog.messages) == 1
    assert "NUMBA_CACHE_DIR is passed over" in caplog.text


@pytest.mark.skipif(os.name != "posix", reason="folders have no such owners")
def test_kernels_are_compiled_in_memory_where_every_folder_is_another_users(
    imported: Callable[[], Any], tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "geteuid", lambda: 4242)
    assert imported()(1) == 2
    assert not kept(tmp_path)
    assert [
        message for message in caplog.messages if "set NUMBA_CACHE_DIR to a folder of your own" in message
    ] == caplog.messages
    assert len(caplog.messages) == 1


def test_a_process_that_another_one_has_begun_does_not_say_it_again(tmp_path: Path) -> None:
    (tmp_path / "file").touch()  # where the folder would be
    again = "import subprocess, sys, hhrl_envs; subprocess.run([sys.executable, '-c', 'import hhrl_envs'])"
    unsaid = {name: value for name, value in os.environ.items() if name != _SAID}
    ended = subprocess.run(
        [sys.executable, "-c", again],
        env=unsaid | {"NUMBA_CACHE_DIR": str(tmp_path / "file")},
        capture_output=True,
        text=True,
        check=True,
    )
    (line,) = ended.stderr.splitlines()
    assert line.startswith(f"hhrl_envs: NUMBA_CACHE_DIR is passed over: {tmp_path / 'file'}")


def test_a_folder_that_cannot_be_written_any_more_does_not_matter(imported: Callable[[], Any], tmp_path: Path) -> None:
    more = imported()
    shutil.rmtree(tmp_path / "kept")
    (tmp_path / "kept").touch()
    assert more(1) == 2


def test_a_home_that_is_not_known_makes_no_folder_called_tilde(
    imported: Callable[[], Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    monkeypatch.setenv("XDG_CACHE_HOME", "~/.cache")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "little" / "__pycache__").touch()  # a file, where the folder would be
    assert imported()(1) == 2
    assert not (tmp_path / "~").exists()


def test_a_simulator_that_must_not_compile_says_so() -> None:
    command = [sys.executable, "-c", "import hhrl_envs"]
    ended = subprocess.run(
        command, env={**os.environ, "NUMBA_DISABLE_JIT": "1"}, capture_output=True, text=True, check=False
    )
    assert ended.returncode == 1
    assert ended.stderr.strip().endswith("NUMBA_DISABLE_JIT is set, but the simulator only runs compiled; unset it")
