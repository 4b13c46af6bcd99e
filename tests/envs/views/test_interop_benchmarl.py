"""BenchMARL trains on the PettingZoo view, whose agents leave one by one."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from hhrl_envs import NumericInfos, triad

pytest.importorskip("benchmarl", reason="BenchMARL is not installed; run: make interop")
from benchmarl.algorithms import IppoConfig
from benchmarl.environments.common import Task
from benchmarl.environments.pettingzoo.common import PettingZooClass
from benchmarl.experiment import Experiment, ExperimentConfig
from benchmarl.models.mlp import MlpConfig
from torchrl.envs import EnvBase, PettingZooWrapper

pytestmark = pytest.mark.filterwarnings("ignore")  # of packages that are not ours


class Ours(PettingZooClass):  # type: ignore[misc]
    """BenchMARL's own PettingZoo task with the environment of a scenario."""

    def get_env_fun(
        self, num_envs: int, continuous_actions: bool, seed: int | None, device: Any
    ) -> Callable[[], EnvBase]:
        def make() -> EnvBase:
            view = NumericInfos(triad(self.config["scenario"]).parallel_env(continuous_actions=continuous_actions))
            arguments = {"categorical_actions": True, "return_state": True, "use_mask": True, "done_on_any": False}
            return PettingZooWrapper(view, seed=seed, device=device, **arguments)

        return make

    def supports_continuous_actions(self) -> bool:
        return True

    def supports_discrete_actions(self) -> bool:
        return True

    def has_state(self) -> bool:
        return True

    def has_render(self, env: EnvBase) -> bool:
        return False

    def max_steps(self, env: EnvBase) -> int:
        return 1200


class OurTask(Task):  # type: ignore[misc]
    """The tasks of hhrl_envs."""

    PLATOON: Any = None

    @staticmethod
    def associated_class() -> type[Ours]:
        return Ours


def test_ippo_trains(tmp_path: Path) -> None:
    config = ExperimentConfig.get_from_yaml()
    config.max_n_iters, config.on_policy_collected_frames_per_batch, config.on_policy_n_envs_per_worker = 2, 1000, 1
    config.on_policy_n_minibatch_iters, config.loggers, config.save_folder = 1, [], str(tmp_path)
    config.evaluation, config.create_json = False, False
    config.on_policy_minibatch_size, config.sampling_device, config.train_device = 200, "cpu", "cpu"
    task = OurTask.PLATOON.get_task(config={"scenario": "platoon-v0"})
    model = MlpConfig.get_from_yaml()
    experiment = Experiment(task, IppoConfig.get_from_yaml(), model, seed=0, config=config, critic_model_config=model)
    experiment.run()
    assert experiment.total_frames >= 2000
