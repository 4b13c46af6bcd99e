import pytest

from hhrl_envs import SCENARIOS, get_scenario
from hhrl_envs.golden import trajectory_digest

GOLDEN = {
    "stop-line-v0": "97acb9ae2a5fbcbdf9b20ea20e0ab73a122a3cf19403bb8b10e3dbd989990e68",
    "stop-line-heldout-v0": "11a61ded2736debd12149d1a3981617d8422b0654c4e52d7e60b18b34835e83e",
    "stop-line-dense-v0": "547f42d85136bafaaae5a75ad53620eefce520c0fc4cdbb1b246399e301d9fee",
    "stop-line-erratic-v0": "fa400b8b4b575d33d476edde963bef2439125737f32ccb0fb8813e5113cadf9f",
    "stop-line-wet-v0": "87cc53ee30ce735a7c9c12e72d0f64c3a4cbd71dcf8f66b98da6fc8379b342fe",
    "stop-line-noisy-v0": "5218bff2331c47cbb32bca438f7cc90d0f3205c1ebb66ee1b8e32df9a7446e6b",
    "follow-v0": "1044d02530642cfadd4d48b8183af680616bb2880a11d88c34e0b842c3b29b66",
    "solo-stop-v0": "3a97cc54ead1f3044f93703e325221e2363cef1943ef18367d967dd7f38ec261",
    "red-light-v0": "63a223c22a5e8a877a071821eb10eb39a1f5d76f3653a4cdae157d86ecb89bef",
    "stop-and-go-v0": "18e42626daf39a9b44dad7f14e31a5e0a330b6ecc6a8ba655b6281570f91d4d5",
    "two-stops-v0": "d27a352ef5f02bb32dd0254829721508e910a6cb6e7e36f1d7a50f217a5cd677",
}


@pytest.mark.parametrize("scenario_id", SCENARIOS)
def test_trajectories_match_their_golden_digest(scenario_id: str) -> None:
    digest = trajectory_digest(get_scenario(scenario_id))
    assert digest == GOLDEN[scenario_id], f"{scenario_id}: trajectories changed, say so in the CHANGELOG: {digest}"
