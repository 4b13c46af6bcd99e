"""A run directory: one method trained on one task, with every seed's curve and checkpoints.

``config.json`` says what is trained, the same for all seeds in the directory. Seed k has ``curve-seed-k.jsonl``, one
line a report, and, once its training has ended, ``seed-k.safetensors`` (best on validation episodes) and
``seed-k.final.safetensors``. A training that was killed leaves curves only, and may be started again in the same place.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hhrl_agents.files import OutputError, require_writable, write_atomically


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

    def prepare(self, config: Mapping[str, Any], seeds: Sequence[int]) -> None:
        """Return nothing; make the directory and its ``config.json``.

        Raises:
            OutputError: if it cannot be written, holds a run of another configuration, or one of the seeds already.
        """
        path, text = self.folder / "config.json", json.dumps(config, indent=2) + "\n"
        require_writable(path)
        if path.exists() and path.read_text(encoding="utf-8", errors="replace") != text:
            raise OutputError(f"{self.folder} holds a run of another configuration; name another folder with --out")
        trained = [seed for seed in seeds if self.best(seed).exists() or self.final(seed).exists()]
        if trained:
            raise OutputError(f"{self.folder} holds seed {trained[0]} already; name another folder with --out")
        write_atomically(path, text)

    def write_curve(self, seed: int, rows: Sequence[Mapping[str, Any]]) -> None:
        """Return nothing; write the learning curve of a seed, one JSON object a line."""
        text = "".join(json.dumps(row, allow_nan=False) + "\n" for row in rows)
        write_atomically(self.folder / f"curve-seed-{seed}.jsonl", text)
