import pytest

from hhrl_envs import SCENARIOS, get_scenario
from hhrl_envs.golden import trajectory_digest

GOLDEN = {"stop-line-v0": "da6726d618acfe44fb7f8bee66cad28a7a10b6f9828a3816fe4f9e118505e8de"}


@pytest.mark.parametrize("scenario_id", SCENARIOS)
def test_trajectories_match_their_golden_digest(scenario_id: str) -> None:
    digest = trajectory_digest(get_scenario(scenario_id))
    assert digest == GOLDEN[scenario_id], f"{scenario_id}: trajectories changed, say so in the CHANGELOG: {digest}"
