"""Agents for the stop-line benchmark: rule agents (numpy) and learned agents (torch, imported where used)."""

from hhrl_agents.base import Agent, Decision, HierarchicalAgent
from hhrl_agents.registry import METHODS, RULES

__all__ = ["METHODS", "RULES", "Agent", "Decision", "HierarchicalAgent"]
