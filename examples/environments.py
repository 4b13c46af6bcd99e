"""Use the environments: PettingZoo with two learned front vehicles, Gymnasium, and a thousand worlds at once."""

import gymnasium
import numpy as np

from hhrl_envs import platoon_v0

env = platoon_v0.parallel_env(learned_fronts=2)
observations, infos = env.reset(seed=7)
while env.agents:
    actions = {agent: env.action_space(agent).sample() for agent in env.agents}
    observations, rewards, terminations, truncations, infos = env.step(actions)
print("PettingZoo:", {agent: info["outcome"].name for agent, info in infos.items()})

single = gymnasium.make("hhrl_envs/StopLine-v0")
observation, info = single.reset(seed=7)
done, total = False, 0.0
while not done:
    observation, reward, terminated, truncated, info = single.step(0)
    done, total = terminated or truncated, total + float(reward)
print(f"Gymnasium: r^task sums to {total:.2f}, r^option of every option is {info['reward_option']}")

worlds = gymnasium.make_vec("hhrl_envs/StopLine-v0", num_envs=1_000, vectorization_mode="vector_entry_point")
batch, infos = worlds.reset(seed=0)
ended = 0
for _ in range(300):
    coasting = np.full(1_000, 3)  # the level 0 m/s^2
    batch, rewards, terminated, truncated, infos = worlds.step(coasting)
    ended += int(terminated.sum() + truncated.sum())
print(f"vector environment: {ended} episodes ended in 300 steps of 1,000 worlds")
