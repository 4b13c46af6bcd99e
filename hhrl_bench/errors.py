"""Errors of the harness: bad usage or input, said in one line."""

from hhrl_envs.errors import InputError


class TaskError(InputError):
    """A task of a user's own that cannot be taken, or must not pass for a registered one."""


class UnknownTaskError(InputError):
    """A task id that is not registered."""


class UnknownSuiteError(InputError):
    """A suite id that is not registered."""


class SuiteError(InputError):
    """A suite that cannot be registered."""


class SeedError(InputError):
    """A list of seeds, or a number of episodes, that the seed ranges cannot serve."""


class AgentError(InputError):
    """An agent that cannot be found, loaded or played in this task."""


class FailedAgentError(AgentError):
    """A user's own agent that fails in its process; other agents can still be scored."""


class RecordError(InputError):
    """A leaderboard or progress file that is not one."""


class CurveError(InputError):
    """Learning curves that are none, or that cannot be compared."""


class LostWorkerError(InputError):
    """A process of a command's own that has ended before its work."""


class ClusterError(InputError):
    """A cluster that does not answer, or a node that is not as the others are."""


class TuningError(InputError):
    """A search for the numbers of an agent that cannot be made."""
