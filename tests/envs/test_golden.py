import pytest

from hhrl_envs import SCENARIOS, get_scenario
from hhrl_envs.golden import trajectory_digest

GOLDEN = {
    "stop-line-v0": "ffbf605cf3975248f2669a63c5a8efb2396c7dbe376bd9373e1fb424971ec2ea",
    "stop-line-heldout-v0": "32d9151bd95da9fb1c1f9eed12fbf80cba571c753171fe16ccd6d8092721dfb9",
    "stop-line-dense-v0": "ce618276709cfd74eaa100d190e00c3748692bb41c077001e520423eaacedbd5",
    "stop-line-erratic-v0": "120405a8e896125f38487358fe61201099efab887ff6a00ed05e067fa68c4ce6",
    "stop-line-wet-v0": "a22f9bc4cc5ee1d6102b1b8d51f32e6efd294f50334299359a12741297c48c6f",
    "stop-line-noisy-v0": "ec83cf21a5a91f06546b439369a9ebfe97dba797d2207e040ceeac03aa1c8873",
    "follow-v0": "bf5e0fdf21621e2b383ee975211f4536e6d1b6b9d2b01e2dc8364ec4fe6ca1b4",
    "solo-stop-v0": "3a97cc54ead1f3044f93703e325221e2363cef1943ef18367d967dd7f38ec261",
    "red-light-v0": "20136fccdd20bb17c91db91654a430d4621808a4ce30dd7f279a93c141d3483e",
    "stop-and-go-v0": "baf5be4dc3a3ac2c2fff7b151e07b54668bdf2000a7f34389a8eb8cb2740c15b",
    "two-stops-v0": "f1fd779b5666d2e7d6afd4413b50e74fbf28f41dcc539feea7fd7c1dc5907135",
    "platoon-v0": "2ae0897903114ad7f276bdde4212777d7608ae52904999d1f7fcaef96be59ebf",
    "adversary-v0": "42e226f3c5590052500cec4b62c7aa312cd1f071204405bcb4364da53ec4911e",
}


@pytest.mark.parametrize("scenario_id", SCENARIOS)
def test_trajectories_match_their_golden_digest(scenario_id: str) -> None:
    digest = trajectory_digest(get_scenario(scenario_id))
    assert digest == GOLDEN[scenario_id], f"{scenario_id}: trajectories changed, say so in the CHANGELOG: {digest}"
