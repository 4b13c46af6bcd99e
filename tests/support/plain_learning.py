"""What Double DQN learns from, in plain torch, float64 and sample by sample, to hold what is compiled against."""

import torch
from torch import Tensor

from hhrl_agents.agent import LEVELS
from hhrl_agents.methods.method import Method
from hhrl_agents.replay.buffer import ACTIONS, DISCOUNT, NUMBERS, OPTIONS, REWARDS, Transitions
from hhrl_envs import Scenario
from hhrl_envs.arrays import Floats32, Ints
from support import plain_networks
from support.plain_networks import Leaves


def transitions(rows: Floats32) -> Transitions:
    """Return the replay's packed rows [n, numbers] taken apart."""
    features = (rows.shape[1] - NUMBERS) // 2
    numbers = rows[:, 2 * features :]
    return Transitions(
        observations=rows[:, :features],
        options=numbers[:, OPTIONS].astype(int),
        actions=numbers[:, ACTIONS].astype(int),
        rewards=numbers[:, REWARDS : REWARDS + len(LEVELS)].astype(float),
        discounts=numbers[:, DISCOUNT].astype(float),
        next_observations=rows[:, features : 2 * features],
    )


def values(method: Method, leaves: Leaves, level: str, states: Tensor, options: Tensor | None = None) -> Tensor:
    """Return one level's values [K, C] of states [K, features]; options [K] are read by the actions of a hierarchy."""
    own, config = plain_networks.below(leaves, f"{level}."), method.config
    if options is None:
        return plain_networks.mlp(own, states, layer_norm=config.layer_norm)
    plain = {"attended": config.attended, "layer_norm": config.layer_norm, "sees_line": config.sees_line}
    return plain_networks.action_values(own, states, torch.eye(2).double()[options], **plain)


def td_errors(
    method: Method, scenario: Scenario, online: Leaves, target: Leaves, step: Transitions, given: Ints
) -> dict[str, Tensor]:
    """Return the errors Y - Q of each level, [K], whose gradients reach the `online` leaves.

    Advantage learning takes alpha (max Q' - Q') of the target network at the states themselves off Y. given: int64 [K],
    the options at the next states where no network says them.
    """
    states, following = (torch.from_numpy(s.copy()).double() for s in (step.observations, step.next_observations))
    chosen = {"option": torch.from_numpy(step.options), "action": torch.from_numpy(step.actions)}
    here, there = (chosen["option"], torch.from_numpy(given)) if method.hierarchical else (None, None)
    absent = {"option": [not present for present in scenario.option_mask], "action": [False] * scenario.num_actions}
    errors = {}
    for level in method.levels:
        read, next_read = (None, None) if level == "option" else (here, there)
        hidden = torch.tensor(absent[level])
        best = values(method, online, level, following, next_read).masked_fill(hidden, -torch.inf).argmax(1)
        aims = values(method, target, level, following, next_read).detach()
        lagged = values(method, target, level, states, read).detach()
        highest = lagged.masked_fill(hidden, -torch.inf).amax(1)
        found = values(method, online, level, states, read)
        errors[level] = torch.stack(
            [
                step.rewards[k, LEVELS.index(level)]
                + step.discounts[k] * aims[k, best[k]]
                - method.config.advantage_learning * (highest[k] - lagged[k, chosen[level][k]])
                - found[k, chosen[level][k]]
                for k in range(len(states))
            ]
        )
        there = best if level == "option" else there
    return errors
