"""The networks of Figure 2 as plain torch modules: one seed, batches of rows, float32 [B, features].

The modules are named so that a parameter of `PolicyModule` has the name that it has in a checkpoint.
"""

from collections.abc import Sequence
from itertools import pairwise

import torch
from torch import Tensor, nn
from torch.nn.functional import layer_norm, one_hot

from hhrl_agents.agent import NO_OPTION
from hhrl_agents.methods.method import Method
from hhrl_agents.policies.learned_agent import given_options
from hhrl_envs import SUB_GOALS, Scenario
from hhrl_envs.errors import InputError
from hhrl_envs.observation import SIZE, SYMBOLS
from hhrl_envs.sub_goals import SSL

NUM_OPTIONS = len(SUB_GOALS)
_LINE = [SYMBOLS.index(element.symbol) for element in SSL.elements]
_EPSILON = 1e-5  # what layer normalisation adds to the variance


class MLP(nn.ModuleList):
    """Fully connected layers: ReLU inside, linear at the end.

    sizes: units of all layers, the inputs first; normalise: what enters every ReLU, to mean 0 and variance 1 over the
    units of the layer.
    """

    def __init__(self, sizes: Sequence[int], *, normalise: bool = False) -> None:
        super().__init__(nn.Linear(fan_in, fan_out) for fan_in, fan_out in pairwise(sizes))
        self._normalise = normalise

    def forward(self, inputs: Tensor) -> Tensor:
        """Return the last layer's outputs, [B, out]."""
        *hidden, last = self
        for layer in hidden:
            inputs = layer(inputs)
            if self._normalise:
                inputs = layer_norm(inputs, inputs.shape[-1:], eps=_EPSILON)
            inputs = inputs.relu()
        outputs: Tensor = last(inputs)
        return outputs


class Attention(nn.Module):
    """I(s, o) = softmax(Linear(s) + Linear(o)), and s^I = SIZE I * s.

    of_linear: the figure's literal s^I = SIZE I * Linear(s). The weights come from the observation alone, and weigh the
    traces behind it too.
    """

    def __init__(self, *, of_linear: bool = False) -> None:
        super().__init__()
        self.state = nn.Linear(SIZE, SIZE)
        self.option = nn.Linear(NUM_OPTIONS, SIZE, bias=False)
        self._of_linear = of_linear

    def weights(self, states: Tensor, options: Tensor) -> Tensor:
        """Return I(s, o), [B, SIZE], for states [B, features] and one-hot options [B, options]."""
        scores: Tensor = self.state(states[:, :SIZE]) + self.option(options)
        return scores.softmax(-1)

    def forward(self, states: Tensor, options: Tensor) -> Tensor:
        """Return s^I, [B, features], for states [B, features] and one-hot options [B, options]."""
        weights = self.weights(states, options)
        multiplied = self.state(states[:, :SIZE]) if self._of_linear else states
        attended: Tensor = SIZE * weights.unsqueeze(1) * multiplied.unflatten(1, (-1, SIZE))
        return attended.flatten(1)


class ActionNetwork(nn.Module):
    """Q^a(s^I, o, a): attention over the elements of the state given the option, then fully connected layers.

    Without attention s^I = s. Without `config.sees_line` the elements of s that belong to the stop-line are 0.
    """

    def __init__(self, method: Method, num_actions: int) -> None:
        super().__init__()
        config = method.config
        self.values = MLP(
            (config.features + NUM_OPTIONS, *config.hidden, num_actions),
            normalise=config.layer_norm,
        )
        self.attention = Attention(of_linear=config.attended == "linear") if method.attention else None
        seen = torch.ones(config.features // SIZE, SIZE)
        seen[:, _LINE] = float(config.sees_line)
        self.register_buffer("_seen", seen.flatten(), persistent=False)

    def forward(self, states: Tensor, options: Tensor) -> Tensor:
        """Return the action values, [B, actions], for states [B, features] and one-hot options [B, options]."""
        states = states * self.get_buffer("_seen")
        attended = states if self.attention is None else self.attention(states, options)
        values: Tensor = self.values(torch.cat((attended, options), 1))
        return values

    def weights(self, states: Tensor, options: Tensor) -> Tensor:
        """Return the attention I(s, o), [B, SIZE]; uniform without attention."""
        if self.attention is None:
            return torch.full_like(states[:, :SIZE], 1 / SIZE)
        return self.attention.weights(states * self.get_buffer("_seen"), options)


class PolicyModule(nn.Module):
    """The networks of the levels that a method learns, for a scenario; both levels act at every step.

    A level that a rule or the analytic controllers give has no network here. The option level's rule is asked where an
    option is needed; a given action level cannot be. Of an action level that is given by a trained follower the
    follower's own networks are in `ffv`, without gradients.
    """

    def __init__(self, method: Method, scenario: Scenario) -> None:
        super().__init__()
        self.method, self.scenario = method, scenario
        config, levels = method.config, method.levels
        sizes = (config.features, *config.hidden)
        if "option" in levels:
            self.option = MLP((*sizes, NUM_OPTIONS), normalise=config.layer_norm)
        elif method.hierarchical:
            self._given_options = given_options(method, scenario)
        if "action" in levels:
            flat = MLP((*sizes, scenario.num_actions), normalise=config.layer_norm)
            self.action = ActionNetwork(method, scenario.num_actions) if method.hierarchical else flat
        if method.ffv:
            self.ffv = PolicyModule(method.ffv, scenario).requires_grad_(requires_grad=False)
        self.register_buffer("_has_option", torch.tensor(scenario.option_mask), persistent=False)

    def forward(self, features: Tensor, options: Tensor | None = None) -> Tensor | tuple[Tensor, Tensor]:
        """Return option values and action values, or those of the one level that is learned, [B, choices] each.

        features: float32 [B, features], the observation first, then its traces; options: int64 [B], what the action
        level is to pursue, the best options if None.
        """
        if self.method.levels == ("option",):
            return self.option_values(features)
        if self.method.levels == ("action",):
            return self.action_values(features, options)
        values = self.option_values(features)
        return values, self.action_values(features, values.argmax(1) if options is None else options)

    def option_values(self, features: Tensor) -> Tensor:
        """Return Q^o(s, .), [B, options], -infinity where the scenario has no such option."""
        return torch.where(self.get_buffer("_has_option"), self.option(features), -torch.inf)

    def action_values(self, features: Tensor, options: Tensor | None = None) -> Tensor:
        """Return Q^a(s^I, o, .), [B, actions], or Q(s, .) of a flat method, which ignores the options.

        Raises:
            InputError: if the action level is given, and has no values.
        """
        if "action" not in self.method.levels:
            raise InputError(f"method {self.method.id!r} has no action values: its action level is given")
        if self.method.hierarchical:
            options = self.best_options(features) if options is None else options
            values: Tensor = self.action(features, one_hot(options, NUM_OPTIONS).to(features.dtype))
        else:
            values = self.action(features)
        return values

    def best_options(self, features: Tensor) -> Tensor:
        """Return the options, int64 [B]: of the highest value, or what the rule selects; -1 of a flat method."""
        if "option" in self.method.levels:
            return self.option_values(features).argmax(1)
        if not self.method.hierarchical:
            return torch.full((len(features),), NO_OPTION, device=features.device)
        return torch.from_numpy(self._given_options(features.cpu().numpy())).to(features.device)
