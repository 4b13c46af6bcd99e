"""The registered agents: rules that act at once, and methods that learn. Nothing here imports torch."""

import pkgutil
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from importlib import import_module
from types import MappingProxyType
from typing import Any

from hhrl_agents import rules
from hhrl_agents.agent import HierarchicalAgent
from hhrl_agents.methods.configs import DoubleDQNConfig, PPOConfig, PQNConfig
from hhrl_agents.methods.method import Method
from hhrl_agents.rules.oracle import ORACLES
from hhrl_envs import Scenario
from hhrl_envs.errors import InputError

MakesRule = Callable[[Scenario], HierarchicalAgent]
"""The constructor of a rule agent."""

_rules: dict[str, MakesRule] = {}

RULES: Mapping[str, MakesRule] = MappingProxyType(_rules)
"""Every rule agent's constructor by its id: the `RULES` of the modules in `hhrl_agents.rules`, and registered ones."""


def register_rule(rule: str, make: MakesRule) -> None:
    """Make a rule agent known by its id, `rule-` and small letters, digits or hyphens.

    Raises:
        InputError: if the id is another word or is taken, or nothing can be made.
    """
    if not re.fullmatch(r"rule-[a-z0-9][a-z0-9-]*", rule) or _rules.get(rule, make) is not make:
        raise InputError(f"a rule cannot have the id {rule!r}; write another word that begins with 'rule-'")
    if not callable(make):
        raise InputError(f"rule {rule!r} is made by {make!r}; give a function of a scenario that returns the agent")
    _rules[rule] = make


for _module in pkgutil.iter_modules(rules.__path__):
    for _rule, _make in getattr(import_module(f"{rules.__name__}.{_module.name}"), "RULES", {}).items():
        register_rule(_rule, _make)


_DDQN = Method("ddqn", summary="flat Double DQN")

_HYBRID = Method(
    "hybrid-hrl",
    option="learned",
    hybrid_reward=True,
    replay="hierarchical",
    attention=True,
    summary="Hybrid HRL: hybrid reward, hierarchical replay, attention",
)

_PAPER = (
    _DDQN,
    Method("hrl-0", option="learned", summary="hierarchical Double DQN, r^task at both levels"),
    replace(_HYBRID, id="hrl-1", replay="uniform", attention=False, summary="HRL-0 and hybrid reward"),
    replace(_HYBRID, id="hrl-2", attention=False, summary="HRL-1 and hierarchical replay"),
    replace(_HYBRID, id="hrl-3", replay="uniform", summary="HRL-1 and attention"),
    _HYBRID,
)

_FOLLOW = Method(
    "follow-only",
    option="rule-1",
    hybrid_reward=True,
    config=DoubleDQNConfig(sees_line=False),
    summary="actions learned, option held at FFV, blind to the line",
)

_GIVEN_LEVELS = (
    _FOLLOW,
    Method(
        "option-only",
        option="learned",
        ffv=_FOLLOW,
        hybrid_reward=True,
        summary="options learned, actions by the SSL controller and the trained follow-only",
    ),
    Method(
        "rule-option",
        option="rule-4",
        hybrid_reward=True,
        replay="prioritised",
        attention=True,
        summary="actions learned, options by Rule 4",
    ),
)


def _reading(name: str, summary: str, **values: Any) -> Method:
    """Return Hybrid HRL with other hyperparameters: a literal reading of the paper, to measure what it is worth."""
    config = replace(_HYBRID.config, **values)
    return replace(_HYBRID, id=f"hybrid-hrl-{name}", config=config, summary=f"Hybrid HRL, {summary}")


_READINGS = (
    _reading("figure-2", "attention on the linear layer (Figure 2)", attended="linear"),
    _reading("algorithm-2", "failures charged as Algorithm 2 does", credit="algorithm-2"),
    _reading("every-call", "target networks copied at every call", target_interval=1, target_rate=1.0),
    _reading("shift", "p^a less the batch's minimum", priority="shift"),
    _reading("terminal-timeout", "the time limit as a terminal penalty", timeout="terminal"),
)

_PLAIN_REPLAY = (
    replace(_DDQN, id="ddqn-per", replay="prioritised", summary="flat Double DQN, prioritised replay"),
    replace(_HYBRID, id="hybrid-hrl-per", replay="prioritised", summary="Hybrid HRL, plain prioritised replay"),
)

_BEYOND = DoubleDQNConfig(n_steps=3, advantage_learning=0.5, memory=(0.1, 0.03), gamma=0.997, jerk_weight=0.3)

_PLUS = (
    replace(_HYBRID, id="hybrid-hrl-plus", config=_BEYOND, summary="Hybrid HRL, 3-step advantage learning, memory"),
    replace(_DDQN, id="ddqn-plus", config=_BEYOND, summary="what Hybrid HRL plus is without options"),
)

_CONTROLS = (
    Method("pqn", config=PQNConfig(), summary="PQN, without replay and target network"),
    Method("ppo", config=PPOConfig(), summary="PPO by Stable-Baselines3"),
)

_TRAFFIC = (
    replace(
        _HYBRID,
        id="platoon",
        config=replace(_BEYOND, layer_norm=True),
        summary="Hybrid HRL plus, layer normalisation, driving all vehicles of platoon-v0",
    ),
    replace(
        _DDQN,
        id="adversary",
        config=replace(_BEYOND, advantage_learning=0.9, memory=(0.1, 0.03, 0.003), gamma=0.999, jerk_weight=0.0),
        summary="flat, the front vehicle of adversary-v0 that makes the ego fail",
    ),
)

_methods: dict[str, Method] = {
    method.id: method for method in (*_PAPER, *_PLUS, *_CONTROLS, *_GIVEN_LEVELS, *_READINGS, *_PLAIN_REPLAY, *_TRAFFIC)
}

METHODS: Mapping[str, Method] = MappingProxyType(_methods)
"""Every learning method by its id.

Flat Double DQN and the rows of the paper's table of HRL-based policies, what goes beyond it, controls of other kinds,
methods that learn one level alone, the literal readings of what the paper contradicts or leaves open, and plain
prioritised replay.
"""


def register_method(method: Method) -> Method:
    """Make a learned method known by its id, small letters, digits and hyphens, and return it.

    Raises:
        InputError: if the id is another word or a rule's, or another method has it.
    """
    if not isinstance(method, Method):
        raise InputError(f"cannot register {method!r} as a method; give a hhrl_agents.methods.method.Method")
    if not re.fullmatch(r"[a-z0-9][a-z0-9-]*", method.id):
        raise InputError(f"a method cannot have the id {method.id!r}; write small letters, digits and hyphens")
    if method.id in {*RULES, *ORACLES} or _methods.get(method.id, method) != method:
        raise InputError(f"there is an agent {method.id!r} already; give the method another id")
    _methods[method.id] = method
    return method
