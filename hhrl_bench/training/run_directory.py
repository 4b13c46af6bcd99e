"""A run directory: one method trained on one task, with every seed's curve and checkpoints.

``config.json`` says what is trained, the same for all seeds in the directory. Seed k has ``curve-seed-k.jsonl``, one
line a report, ``seed-k.safetensors`` (best on validation episodes so far) and, once its training has ended,
``seed-k.final.safetensors``; a seed that diverged has ``seed-k.failed.json`` in their place. As long as seeds are being
trained there is their ``state-seeds-*.safetensors``, from which ``--resume`` goes on. A longer training goes on from
``end-state-seed-k.safetensors``, which ``train`` leaves. The process that trains seed k holds the lock of
``seed-k.lock``.
"""

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from hhrl_agents.atomic_files import (
    OutputError,
    made_folder,
    remove_fragments,
    require_writable,
    write_atomically,
)
from hhrl_bench.locks import locked
from hhrl_bench.provenance import ProvenanceRecord
from hhrl_bench.tasks.seeds import format_seeds, parse_seeds

STATE_NAME = "state-seeds-{}.safetensors"


@dataclass(frozen=True, slots=True)
class RunDirectory:
    """The paths of a run directory."""

    folder: Path

    def best(self, seed: int) -> Path:
        """Return the path of the checkpoint that validation chose."""
        return self.folder / f"seed-{seed}.safetensors"

    def final(self, seed: int) -> Path:
        """Return the path of the last checkpoint."""
        return self.folder / f"seed-{seed}.final.safetensors"

    def failed(self, seed: int) -> Path:
        """Return the path of the record of a seed that has diverged."""
        return self.folder / f"seed-{seed}.failed.json"

    def curve(self, seed: int) -> Path:
        """Return the path of a seed's learning curve."""
        return self.folder / f"curve-seed-{seed}.jsonl"

    def state(self, seeds: Sequence[int]) -> Path:
        """Return the path of the state of seeds that are trained side by side."""
        return self.folder / STATE_NAME.format(format_seeds(seeds))

    def end_state(self, seed: int) -> Path:
        """Return the path of the state in which the training of a seed has ended."""
        return self.folder / f"end-state-seed-{seed}.safetensors"

    def provenance(self, seeds: Sequence[int]) -> Path:
        """Return the path of the provenance of seeds that were trained side by side."""
        return self.folder / f"provenance-seeds-{format_seeds(seeds)}.json"

    def seconds(self, seed: int) -> float:
        """Return how long the training of a seed by itself, which has ended, took; 0 if nothing says so."""
        try:
            record = ProvenanceRecord.model_validate_json(self.provenance((seed,)).read_bytes())
            return sum(record.wall_seconds.values())
        except (OSError, ValidationError):
            return 0.0

    def finished(self, seeds: Sequence[int]) -> bool:
        """Return whether the training of all these seeds has ended."""
        return not self.state(seeds).exists() and all(self._ended(seed) for seed in seeds)

    def ended_seeds(self) -> list[int]:
        """Return the seeds whose training has ended, ascending."""
        return _seeds_of(self.folder, r"(?:final\.safetensors|failed\.json)")

    def config(self) -> Mapping[str, Any]:
        """Return what is trained in the directory; nothing if that is not known."""
        try:
            held = _parsed(self._config.read_bytes())
        except OSError:
            return {}
        return held if isinstance(held, dict) else {}

    def write_config(self, config: Mapping[str, Any]) -> None:
        """Write what is trained in the directory."""
        write_atomically(self._config, _text(config))

    @contextmanager
    def at_work(self, seeds: Sequence[int], patience: float) -> Iterator[None]:
        """Let this process, and no other, train these seeds in this context.

        Raises:
            OutputError: if another process trains one of them for more than ``patience`` seconds from now, or the
                directory cannot be written.
        """
        require_writable(self._config)
        with ExitStack() as stack:
            stack.enter_context(made_folder(self.folder))
            for seed in sorted(seeds):
                busy = (
                    f"another training of seed {seed} works in {self.folder}; wait until it has ended, or name another "
                    "folder with --out"
                )
                stack.enter_context(locked(self.folder / f"seed-{seed}.lock", busy, patience, passing=True))
            yield

    def prepare(self, config: Mapping[str, Any], seeds: Sequence[int], *, resume: bool) -> None:
        """Write ``config.json``, and remove what a kill has left of files of these seeds.

        Raises:
            OutputError: if that cannot be written, or the directory holds a run of another configuration, one of the
                seeds already, or an unfinished training of them that is not to be resumed.
        """
        self.require_config(config)
        self._require_no_other_training(seeds, resume=resume)
        trained = [seed for seed in seeds if self._ended(seed) or self.best(seed).exists()]
        if trained and not self.state(seeds).exists():
            raise OutputError(f"{self.folder} holds seed {trained[0]} already; name another folder with --out")
        self._remove_fragments(seeds)
        self.write_config(config)

    def require_config(self, config: Mapping[str, Any]) -> None:
        """Raise an ``OutputError`` if the directory holds a run of another configuration."""
        if self._config.exists() and _parsed(self._config.read_bytes()) != as_read(config):
            raise OutputError(f"{self.folder} holds a run of another configuration; name another folder with --out")

    def write_curve(self, seed: int, rows: Sequence[Mapping[str, Any]]) -> None:
        """Write the learning curve of a seed, one JSON object a line."""
        text = "".join(json.dumps(row, allow_nan=False) + "\n" for row in rows)
        write_atomically(self.curve(seed), text)

    def write_failure(self, seed: int, record: Mapping[str, Any]) -> None:
        """Write why a seed has failed, and remove its checkpoint."""
        write_atomically(self.failed(seed), json.dumps(record, indent=2, allow_nan=False) + "\n")
        self.best(seed).unlink(missing_ok=True)

    @property
    def _config(self) -> Path:
        return self.folder / "config.json"

    def _ended(self, seed: int) -> bool:
        return self.final(seed).exists() or self.failed(seed).exists()

    def _require_no_other_training(self, seeds: Sequence[int], *, resume: bool) -> None:
        prefix, suffix = STATE_NAME.split("{}")
        for path in sorted(self.folder.glob(STATE_NAME.format("*"))):
            spelling = path.name.removeprefix(prefix).removesuffix(suffix)
            others = parse_seeds(spelling)
            if others == tuple(seeds) and resume:
                continue
            if set(others) & set(seeds):
                words = "" if others == tuple(seeds) else f"--seeds {spelling} "
                raise OutputError(
                    f"{self.folder} holds an unfinished training of seeds {spelling}; add {words}--resume to continue "
                    "it, or name another folder with --out"
                )

    def _remove_fragments(self, seeds: Sequence[int]) -> None:
        each = (self.best, self.final, self.failed, self.curve, self.end_state)
        for path in (self.state(seeds), *(name(seed) for name in each for seed in seeds)):
            remove_fragments(self.folder, of=path.name)


def failed_seeds(folder: Path) -> list[int]:
    """Return the seeds of a run directory whose training has failed, ascending."""
    return _seeds_of(folder, r"failed\.json")


def as_read(config: Mapping[str, Any]) -> Any:
    """Return a config as it is when it is read from its file."""
    return _parsed(_text(config).encode())


def _seeds_of(folder: Path, ending: str) -> list[int]:
    """Return the seeds k of the files ``seed-k.`` with such an ending, ascending."""
    named = (re.fullmatch(rf"seed-([0-9]{{1,9}})\.{ending}", path.name) for path in folder.glob("seed-*"))
    return sorted({int(match[1]) for match in named if match})


def _text(config: Mapping[str, Any]) -> str:
    return json.dumps(config, indent=2) + "\n"


def _parsed(text: bytes) -> Any:
    """Return what a config says, whatever the order of its keys; None if it is damaged."""
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return None
