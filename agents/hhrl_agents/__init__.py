"""Agents for the stop-line benchmark: rule agents and learned agents; only training needs torch."""

from hhrl_agents.agent import Agent, Decision, HierarchicalAgent
from hhrl_agents.methods.registry import METHODS, RULES, register_method, register_rule

__all__ = ["METHODS", "RULES", "Agent", "Decision", "HierarchicalAgent", "register_method", "register_rule"]
