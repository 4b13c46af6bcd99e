"""Agents for the stop-line benchmark: rule agents, learned agents, and policies of other libraries.

Only some trainings and networks from elsewhere need torch.
"""

from hhrl_agents.adapters.callables import from_callable
from hhrl_agents.adapters.onnx_files import from_onnx
from hhrl_agents.adapters.sb3 import from_sb3
from hhrl_agents.adapters.torch_modules import from_torch
from hhrl_agents.agent import Agent, ClairvoyantAgent, Decision, HierarchicalAgent
from hhrl_agents.methods.registry import METHODS, RULES, register_method, register_rule
from hhrl_agents.rules.oracle import ORACLES

__all__ = [
    "METHODS",
    "ORACLES",
    "RULES",
    "Agent",
    "ClairvoyantAgent",
    "Decision",
    "HierarchicalAgent",
    "from_callable",
    "from_onnx",
    "from_sb3",
    "from_torch",
    "register_method",
    "register_rule",
]
