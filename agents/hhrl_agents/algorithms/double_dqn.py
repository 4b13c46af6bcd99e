"""Double DQN, flat and hierarchical: act, store, learn from the replay, move the target networks."""

import numpy as np

from hhrl_agents.agent import ACTION, LEVELS, NO_OPTION, OPTION
from hhrl_agents.algorithms.td_errors import Batch, Found, Level, Settings, learn, make_room
from hhrl_agents.methods.method import Method
from hhrl_agents.networks.architectures import Parameters
from hhrl_agents.policies.checkpoints import frozen_parameters
from hhrl_agents.policies.learned_agent import given_actions, given_options
from hhrl_agents.replay.buffer import ReplayBuffer
from hhrl_agents.replay.hierarchical import make_sampler
from hhrl_agents.replay.n_step import MultiStep
from hhrl_agents.seeding import Purpose, generator
from hhrl_agents.stateful import Stateful
from hhrl_agents.training.drivers import EGO_ALONE, Drivers
from hhrl_agents.training.exploration import GREEDY
from hhrl_agents.training.learner import NOTHING, Start, ValueLearner
from hhrl_envs import Scenario
from hhrl_envs.arrays import Floats32, Ints, Keys
from hhrl_envs.errors import require_value


class DoubleDQNLearner(ValueLearner):
    """Trains a method by Double DQN, flat or hierarchical."""

    def __init__(
        self,
        method: Method,
        scenario: Scenario,
        seed: int,
        world_seeds: Keys,
        drivers: Drivers = EGO_ALONE,
        start: Start = NOTHING,
    ) -> None:
        super().__init__(method, scenario, seed, world_seeds, drivers, start)
        config, width = self.config, self._environments.width
        capacity = config.replay_capacity
        require_value(capacity >= width, "replay_capacity", capacity, f"at least {width}, a step of every vehicle")
        self._frozen, self._first_epsilon = frozen_parameters(method), start.epsilon
        self._replay = ReplayBuffer(capacity, config.features)
        self._sampler = make_sampler(method, generator(seed, Purpose.REPLAY), len(self.levels), capacity)
        self._multistep = MultiStep(config.n_steps)
        self._mask = np.where(scenario.option_mask, 0.0, -np.inf).astype(np.float32)
        unmasked = np.zeros(scenario.num_actions, np.float32)
        self._levels = self._level(OPTION, self._mask), self._level(ACTION, unmasked)
        if method.hierarchical and "option" not in method.levels:
            self._given_options = given_options(method, scenario)
        if "action" not in method.levels:
            self._given_actions = given_actions(method, scenario, self._frozen)
        drawn = config.batch_size * (len(self.levels) if method.replay == "hierarchical" else 1)
        levels = list(method.levels)
        widths = [self.parameters.widths[level] for level in levels]
        self._room = make_room(widths, [self.parameters.layouts[level] for level in levels], drawn)
        self._found = Found(
            np.zeros((len(self.levels), drawn), np.float32), np.zeros(len(self.levels)), np.zeros(len(self.levels))
        )
        self._unused = np.zeros(drawn, np.int64)
        self._has_values = False

    def _level(self, place: int, mask: Floats32) -> Level:
        name = LEVELS[place]
        layout = self.parameters.layouts.get(name, np.zeros((0, 0), np.int64))
        first, last = self.parameters.parts.get(name, (0, 0))
        return Level(place, layout, mask, name in self.levels, first, last)

    def _advance(self, env_steps: int, span: int) -> None:
        share = self.env_steps / span
        self._interact(self.config.epsilon_at(share, self._first_epsilon))
        while self._update_is_due():
            self._update(self.config.learning_rate_at(share))

    def _interact(self, epsilon: float) -> None:
        """Step every environment once and store what happened."""
        tried = dict(zip(self.levels, (explorer.draw(epsilon) for explorer in self._explorers), strict=True))
        joined = self._multistep.push(*self._environments.step(*self._choose(tried)))
        if joined is not None:
            self._sampler.added(self._replay.add(joined))
        self.env_steps += self.config.n_envs

    def _choose(self, tried: dict[str, Ints]) -> tuple[Ints, Ints]:
        """Return options and actions, int64 [n] each: those tried, and the best ones where nothing is."""
        states, method = self._environments.features, self.method
        greedy = np.full(len(states), GREEDY)
        if not method.hierarchical:
            options = np.full(len(states), NO_OPTION)
        elif "option" in method.levels:
            best = (self._networks["option"].values(states) + self._mask).argmax(axis=1)
            trial = tried.get("option", greedy)
            options = np.where(trial == GREEDY, best, trial)
        else:
            options = self._given_options(states)
        if "action" not in method.levels:
            return options, self._given_actions(states, options)
        trial = tried.get("action", greedy)
        return options, np.where(
            trial == GREEDY, self._networks["action"].values(states, options).argmax(axis=1), trial
        )

    def _update_is_due(self) -> bool:
        return bool(self.updates * self.config.steps_per_update < self.env_steps - self.config.warmup)

    def _update(self, learning_rate: float) -> None:
        """Take one gradient step at every level."""
        config, draw = self.config, self._sampler.draw(self._replay.stored)
        given = self._unused
        if self.method.hierarchical and "option" not in self.method.levels:
            given = self._given_options(self._replay.next_observations(draw.indices))
        batch = Batch(self._replay.rows, draw.indices, given, draw.firsts, draw.weights)
        settings = Settings(config.advantage_learning, learning_rate, config.max_gradient_norm)
        learn(self._memory, self._levels, batch, self._room, settings, self._found)
        self._add_losses(self._found.losses)
        self._sampler.update(draw.indices, self._found.errors)
        self._has_values = True
        self.updates += 1
        if self.updates % config.target_interval == 0:
            self.parameters.move_target(config.target_rate)

    def _parts(self) -> dict[str, Stateful]:
        return {
            **super()._parts(),
            "replay": self._replay,
            "sampler": self._sampler,
            "multistep": self._multistep,
        }

    def _policy_parameters(self) -> Parameters:
        return {**super()._policy_parameters(), **self._frozen}

    def _diverged(self) -> str | None:
        """Return why the values in the last mini-batch cannot be; max |r| is a collision's, or one stored."""
        if not self._has_values:
            return None
        reward, config = self.scenario.reward, self.config
        usual = config.reward_scale * max(reward.sigma_3, reward.sigma_4)
        largest, alpha = max(self._replay.largest_reward(), usual), config.advantage_learning
        values = dict(zip(self.levels, self._found.largest.tolist(), strict=True))
        return beyond_bound(values, largest * (1.0 + alpha) / (1.0 - alpha), config.gamma)

    def _clear_meters(self) -> None:
        super()._clear_meters()
        self._has_values = False


def beyond_bound(reached: dict[str, float], largest_reward: float, gamma: float) -> str | None:
    """Return in words which level's values lie beyond max |r| / (1 - gamma); None if none does.

    reached: level -> the largest absolute value in a mini-batch; largest_reward: max |r|.
    """
    bound = largest_reward / (1.0 - gamma) if gamma < 1.0 else np.inf
    for level, largest in reached.items():
        if largest > bound:
            return f"its {level} values reach {largest:.3g}, the rewards allow {bound:.3g}"
    return None
