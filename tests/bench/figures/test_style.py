"""Agents look the same everywhere, and no two of them alike."""

from hhrl_agents import METHODS, ORACLES, RULES
from hhrl_bench.figures.style import in_order, lines, looks

PUBLISHED = [*(rule for rule in RULES if rule != "rule-4-literal"), "ddqn", "ddqn-plus", "hrl-0", "hrl-1", "hrl-2"]
PUBLISHED += ["oracle", "hrl-3", "hybrid-hrl", "hybrid-hrl-plus", "pqn", "ppo"]


def test_no_two_agents_look_alike() -> None:
    known = looks([*PUBLISHED, "mine", "yours"])
    assert len({look.marker for name, look in known.items() if name in PUBLISHED}) >= 8
    assert len({(look.colour, look.marker) for look in known.values()}) == len(known)
    learned = [look for name, look in known.items() if name not in {*RULES, *ORACLES}]
    assert len({(look.colour, look.dashes) for look in learned}) == len(learned)


def test_an_agent_looks_the_same_in_any_company() -> None:
    everyone = looks(PUBLISHED)
    assert all(looks([agent, "mine"])[agent] == look for agent, look in everyone.items())
    assert {*PUBLISHED} <= {*METHODS, *RULES, *ORACLES}


def test_rules_come_first_and_strangers_last() -> None:
    assert in_order(["mine", "hybrid-hrl", "rule-4", "yours", "mine"]) == ["rule-4", "hybrid-hrl", "mine", "yours"]
    assert [line.name for line in lines(["mine", "rule-4"]).values()] == ["rule-4", "mine"]
