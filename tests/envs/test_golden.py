import pytest

from hhrl_envs import SCENARIOS, get_scenario
from hhrl_envs.golden import trajectory_digest

GOLDEN = {
    "stop-line-v0": "ffbf605cf3975248f2669a63c5a8efb2396c7dbe376bd9373e1fb424971ec2ea",
    "stop-line-heldout-v0": "32d9151bd95da9fb1c1f9eed12fbf80cba571c753171fe16ccd6d8092721dfb9",
    "stop-line-dense-v0": "547ad419eab22bc134e172babf57c5813351778b2c2f70fb9250bc3f8a93da82",
    "stop-line-erratic-v0": "e6da40338bebf6bc3cb69ed8c9e5dc239701a59f298eeec8e708d98d8f1bd516",
    "stop-line-wet-v0": "7062b84a0a5dcccb5beefaa5faae05e3da36517009bc82e4081dae6c426e5a81",
    "stop-line-noisy-v0": "f69cd811132c52bcf8dda4034fde019002c67dbb36ef8928f22e163f41492d0a",
    "follow-v0": "bf5e0fdf21621e2b383ee975211f4536e6d1b6b9d2b01e2dc8364ec4fe6ca1b4",
    "solo-stop-v0": "3a97cc54ead1f3044f93703e325221e2363cef1943ef18367d967dd7f38ec261",
    "red-light-v0": "20136fccdd20bb17c91db91654a430d4621808a4ce30dd7f279a93c141d3483e",
    "stop-and-go-v0": "baf5be4dc3a3ac2c2fff7b151e07b54668bdf2000a7f34389a8eb8cb2740c15b",
    "two-stops-v0": "f1fd779b5666d2e7d6afd4413b50e74fbf28f41dcc539feea7fd7c1dc5907135",
}


@pytest.mark.parametrize("scenario_id", SCENARIOS)
def test_trajectories_match_their_golden_digest(scenario_id: str) -> None:
    digest = trajectory_digest(get_scenario(scenario_id))
    assert digest == GOLDEN[scenario_id], f"{scenario_id}: trajectories changed, say so in the CHANGELOG: {digest}"
