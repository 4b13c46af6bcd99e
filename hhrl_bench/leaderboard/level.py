"""How far an entry is verified; apart from all else, for the command line names the levels in its help."""

from enum import StrEnum


class Level(StrEnum):
    """How far an entry is verified; each level includes those before it.

    schema: it is well-formed, and its tasks are those of this version. recomputed: all that follows from the whole
    numbers of the episodes, from the learning curves and from each other. replayed: the stored decisions, played
    through the simulator again, come to every number of every result. rerun: the agents decide the same in every
    episode again. retrained: the seeds, trained again, leave the same checkpoints.
    """

    SCHEMA = "schema"
    RECOMPUTED = "recomputed"
    REPLAYED = "replayed"
    RERUN = "rerun"
    RETRAINED = "retrained"

    def includes(self, other: "Level") -> bool:
        """Return whether this level includes another."""
        return list(Level).index(self) >= list(Level).index(other)

    def at_most(self, other: "Level") -> "Level":
        """Return this level, or another if this one goes beyond it."""
        return other if self.includes(other) else self
