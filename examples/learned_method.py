"""Add a learned method that is data: Double DQN with wider layers and 5-step returns.

    hhrl-bench --extension examples/learned_method.py train ddqn-wide --seeds 0-1 --env-steps 20000 --out runs/wide
    hhrl-bench --extension examples/learned_method.py evaluate runs/wide

A method says which level is learned or given, and every hyperparameter; what is not given is that of ``ddqn``.
"""

from dataclasses import replace

from hhrl_agents import METHODS, register_method

DDQN = METHODS["ddqn"]

WIDE = register_method(
    replace(
        DDQN,
        id="ddqn-wide",
        config=replace(DDQN.config, hidden=(96, 96), n_steps=5),
        summary="flat Double DQN, wider, with 5-step returns",
    )
)

if __name__ == "__main__":
    import numpy as np

    from hhrl_agents.training.learner import make_learner
    from hhrl_envs import get_scenario

    learner = make_learner(WIDE, get_scenario("stop-line-v0"), seed=0, world_seeds=np.arange(32, dtype=np.uint64))
    for report in learner.train(6_000):
        print(f"{report.env_steps:,} env steps, {report.updates:,} gradient steps, losses {report.losses}")
