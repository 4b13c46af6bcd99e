"""PettingZoo's three names for any scenario: ``parallel_env`` is the native view, ``env`` and ``raw_env`` are AEC.

Every registered scenario has a module with these names, ``from hhrl_envs import stop_line_v0`` for ``stop-line-v0``; a
scenario of your own has ``triad(scenario).parallel_env()``.
"""

from functools import partial
from math import inf
from typing import Any, NamedTuple, Protocol, TypedDict, TypeVar, Unpack

from pettingzoo import AECEnv
from pettingzoo.utils.conversions import parallel_to_aec_wrapper
from pettingzoo.utils.wrappers import OrderEnforcingWrapper

from hhrl_envs.errors import require_value
from hhrl_envs.scenario.registry import SCENARIOS, add_scenario, as_scenario
from hhrl_envs.scenario.scenario import Scenario
from hhrl_envs.views.gym_env import register_gym
from hhrl_envs.views.parallel_env import StopLineParallelEnv

View_co = TypeVar("View_co", covariant=True)
AECView = AECEnv[str, Any, Any]


class ViewArguments(TypedDict, total=False):
    """The keyword arguments of every PettingZoo view; see ``StopLineParallelEnv``."""

    render_mode: str | None
    learned_fronts: int | None
    continuous_actions: bool


class MakesView(Protocol[View_co]):
    """One of PettingZoo's constructors."""

    def __call__(self, **arguments: Unpack[ViewArguments]) -> View_co:
        """Return a new view."""


class Triad(NamedTuple):
    """The three constructors of one scenario's PettingZoo views."""

    env: MakesView[AECView]
    raw_env: MakesView[AECView]
    parallel_env: MakesView[StopLineParallelEnv]


def triad(scenario: Scenario | str) -> Triad:
    """Return the constructors of a registered scenario, by its id, or of a scenario of your own."""
    world = as_scenario(scenario)
    return Triad(partial(_env, world), partial(_raw_env, world), partial(StopLineParallelEnv, world))


def register(scenario: Scenario, place: float = inf, summary: str = "", superseded_by: str | None = None) -> Triad:
    """Make a scenario known by its id, here and in Gymnasium, and return its constructors.

    ``place`` says where it stands in lists: behind those of lower places, and by default behind all of them. The
    ``summary`` says in a few words what is special. One that is kept for old results only is ``superseded_by`` another,
    whose id that is.

    Raises:
        InputError: if another scenario has its id.
    """
    require_value(isinstance(scenario, Scenario), "scenario", repr(scenario), "a Scenario")
    if scenario.id not in SCENARIOS:
        register_gym(scenario)
    add_scenario(scenario, place, summary, superseded_by)
    return triad(scenario)


def _raw_env(scenario: Scenario, **arguments: Unpack[ViewArguments]) -> AECView:
    aec: AECView = parallel_to_aec_wrapper(StopLineParallelEnv(scenario, **arguments))
    return aec


def _env(scenario: Scenario, **arguments: Unpack[ViewArguments]) -> AECView:
    return OrderEnforcingWrapper(_raw_env(scenario, **arguments))
