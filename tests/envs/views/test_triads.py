"""PettingZoo's names: every scenario has its module, and PettingZoo's own checks accept all three views."""

import pickle
import warnings
from functools import partial
from types import ModuleType

import pytest

from hhrl_envs import SCENARIOS, Goal, InputError, Scenario, UnknownScenarioError, triad
from hhrl_envs.views.parallel_env import EGO, StopLineParallelEnv
from hhrl_envs.views.triad import ViewArguments
from hhrl_envs.worlds import WORLDS, stop_line_v0

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test, render_test, seed_test
    from pettingzoo.utils.conversions import aec_to_parallel

EACH = pytest.mark.parametrize("scenario_id", SCENARIOS)
LEARNED = [name for name, each in SCENARIOS.items() if each.traffic.max_fronts > 1 and each.goal != Goal.FOLLOW]
VARIANTS: list[tuple[str, ViewArguments]] = [
    *((name, ViewArguments(learned_fronts=2)) for name in LEARNED),
    ("platoon-v0", ViewArguments(learned_fronts=4)),
    *((name, ViewArguments(continuous_actions=True)) for name in ("follow-v0", "solo-stop-v0", "platoon-v0")),
    ("adversary-v0", ViewArguments(learned_fronts=3, continuous_actions=True)),
    ("stop-line-noisy-v0", ViewArguments(learned_fronts=1, continuous_actions=True)),
]
EACH_VARIANT = pytest.mark.parametrize(("scenario_id", "arguments"), VARIANTS, ids=str)
pytestmark = pytest.mark.filterwarnings("ignore:We recommend agents:UserWarning")  # MPE's names, not a requirement


def module(scenario_id: str) -> ModuleType:
    return WORLDS[scenario_id.replace("-", "_")]


@EACH
def test_every_scenario_has_its_module(scenario_id: str) -> None:
    for name in ("env", "raw_env", "parallel_env"):
        made = getattr(module(scenario_id), name)(render_mode=None)
        assert made.unwrapped.metadata["name"] == module(scenario_id).__name__.removeprefix("hhrl_envs.worlds.")
    assert made.scenario == SCENARIOS[scenario_id]


@EACH
def test_pettingzoo_accepts_the_parallel_view(scenario_id: str) -> None:
    parallel_api_test(module(scenario_id).parallel_env(), num_cycles=300)
    parallel_seed_test(module(scenario_id).parallel_env)


@EACH
def test_pettingzoo_accepts_the_aec_views(scenario_id: str) -> None:
    api_test(module(scenario_id).env(), num_cycles=300)
    api_test(module(scenario_id).raw_env(), num_cycles=300)
    seed_test(module(scenario_id).env)
    assert isinstance(aec_to_parallel(module(scenario_id).env()), StopLineParallelEnv)


@EACH
def test_pettingzoo_accepts_the_pictures(scenario_id: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    render_test(module(scenario_id).env)


@EACH_VARIANT
def test_pettingzoo_accepts_learned_fronts_and_continuous_actions(scenario_id: str, arguments: ViewArguments) -> None:
    views = triad(scenario_id)
    parallel_api_test(views.parallel_env(**arguments), num_cycles=300)
    parallel_seed_test(partial(views.parallel_env, **arguments))
    api_test(views.env(**arguments), num_cycles=300)
    api_test(views.raw_env(**arguments), num_cycles=300)
    seed_test(partial(views.env, **arguments))


@pytest.mark.parametrize("scenario_id", ["stop-line-v0", "platoon-v0"])
def test_pettingzoo_accepts_pictures_of_learned_fronts(scenario_id: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    render_test(partial(module(scenario_id).env, learned_fronts=2, continuous_actions=True))


def test_modules_are_imported_either_way() -> None:
    from hhrl_envs import two_stops_v0  # noqa: PLC0415

    assert two_stops_v0.parallel_env().scenario.id == "two-stops-v0"
    assert stop_line_v0.parallel_env().scenario.id == "stop-line-v0"


def test_triad_takes_a_scenario_of_ones_own() -> None:
    mine = Scenario(id="mine-v0", traffic=SCENARIOS["stop-line-v0"].traffic, horizon=7, feasible_only=False)
    env = triad(mine).parallel_env()
    env.reset(seed=1)
    steps = 0
    while env.agents:
        env.step({EGO: 0})
        steps += 1
    assert steps == 7


def test_constructors_can_be_sent_to_another_process() -> None:
    made = pickle.loads(pickle.dumps(stop_line_v0.parallel_env))()  # noqa: S301  (made here)
    assert made.scenario == SCENARIOS["stop-line-v0"]


def test_unknown_scenarios_and_arguments_are_named() -> None:
    with pytest.raises(UnknownScenarioError, match="'stop-lin-v0'; write one of: stop-line-v0"):
        triad("stop-lin-v0")
    with pytest.raises(InputError, match="scenario is 3; write a registered id"):
        triad(3)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="render_mod"):
        stop_line_v0.env(render_mod="human")  # type: ignore[call-arg]
