"""The registered agents: rules that act at once, and methods that learn. Importable without torch."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

from hhrl_agents.base import HierarchicalAgent
from hhrl_agents.methods import Method
from hhrl_agents.ppo_config import PPOConfig
from hhrl_agents.pqn_config import PQNConfig
from hhrl_agents.rule_plus import RulePlus
from hhrl_agents.rules import PAPER_RULES
from hhrl_envs import Scenario

RULES: Mapping[str, Callable[[Scenario], HierarchicalAgent]] = MappingProxyType({**PAPER_RULES, "rule-plus": RulePlus})
"""Every rule agent's constructor by its id."""

_ALL = (
    Method("ddqn"),
    Method("pqn", config=PQNConfig()),
    Method("ppo", config=PPOConfig()),
    Method("hrl-0", hierarchical=True),
    Method("hrl-1", hierarchical=True, hybrid_reward=True),
    Method("hrl-2", hierarchical=True, hybrid_reward=True, replay="hierarchical"),
    Method("hrl-3", hierarchical=True, hybrid_reward=True, attention=True),
    Method("hybrid-hrl", hierarchical=True, hybrid_reward=True, replay="hierarchical", attention=True),
)

METHODS: Mapping[str, Method] = MappingProxyType({method.id: method for method in _ALL})
"""Every learning method by its id: flat controls, and the rows of the paper's table of HRL-based policies."""
