"""Verification of an entry: what it says, computed again from what it rests on, level by level, offline and on a CPU."""

from collections.abc import Iterator, Sequence
from enum import StrEnum
from functools import cached_property
from typing import NamedTuple

import numpy as np

from hhrl_bench import entry_checks
from hhrl_bench.differences import Finding, differences
from hhrl_bench.episodes import EpisodeRecords
from hhrl_bench.errors import AgentError, RecordError
from hhrl_bench.evaluation import play_task
from hhrl_bench.evidence import Evidence, unpack
from hhrl_bench.leaderboard_record import LeaderboardRecord
from hhrl_bench.loading import LoadedAgent, load_agents
from hhrl_bench.metrics import SCORED
from hhrl_bench.players import OPTIONS
from hhrl_bench.progress import Update, silent
from hhrl_bench.records import ResultRecord, RunRecord, TaskRecord
from hhrl_bench.replaying import replay
from hhrl_bench.results import result_record, run_record
from hhrl_bench.store import Store, read
from hhrl_bench.tasks import Task, get_task
from hhrl_bench.threads import one_torch_thread
from hhrl_envs import get_scenario


class Level(StrEnum):
    """How far an entry is verified; each level includes those before it.

    schema: it is well-formed, and of this version's tasks. recomputed: what whole numbers of the episodes and the
    stored curves come to. replayed: the stored decisions, played through the simulator again, come to every number.
    rerun: the checkpoints, and the registered rules, decide the same again.
    """

    SCHEMA = "schema"
    RECOMPUTED = "recomputed"
    REPLAYED = "replayed"
    RERUN = "rerun"

    def reaches(self, other: "Level") -> bool:
        """Return whether this level includes another."""
        return list(Level).index(self) >= list(Level).index(other)
