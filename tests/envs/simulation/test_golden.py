import pytest

from hhrl_envs import SCENARIOS
from hhrl_envs.simulation.survey import trajectory_digest
from support.hidden import HIDDEN

KNOWN = {**SCENARIOS, **HIDDEN}

GOLDEN = {
    "stop-line-v0": "ffbf605cf3975248f2669a63c5a8efb2396c7dbe376bd9373e1fb424971ec2ea",
    "stop-line-paper-v0": "e53e1f333c3e16123c0c124de2abebe0d49e029590d674b7c21d5ce5a85d4f5f",
    "stop-line-heldout-v0": "32d9151bd95da9fb1c1f9eed12fbf80cba571c753171fe16ccd6d8092721dfb9",
    "stop-line-dense-v0": "be86001e3924d1c571c6d6390eafb7ad881fb56e9a69503ca50cb99d09e3983b",
    "stop-line-erratic-v0": "3bb7de788142f675830f5fae2770d496d5645744f7c9b573b116af5ffc25f315",
    "stop-line-wet-v0": "bf0ba45837632a684e58b4612a20e5797a1f8994035f527458a67f55c3e3a66e",
    "stop-line-noisy-v0": "ed0e0f0230968aab9074a0d4aa4c30090b1428a9aa22d43fa7b0e856653a3f91",
    "follow-v0": "bf5e0fdf21621e2b383ee975211f4536e6d1b6b9d2b01e2dc8364ec4fe6ca1b4",
    "solo-stop-v0": "3a97cc54ead1f3044f93703e325221e2363cef1943ef18367d967dd7f38ec261",
    "red-light-v0": "20136fccdd20bb17c91db91654a430d4621808a4ce30dd7f279a93c141d3483e",
    "stop-and-go-v0": "baf5be4dc3a3ac2c2fff7b151e07b54668bdf2000a7f34389a8eb8cb2740c15b",
    "two-stops-v0": "f1fd779b5666d2e7d6afd4413b50e74fbf28f41dcc539feea7fd7c1dc5907135",
    "platoon-v0": "2ae0897903114ad7f276bdde4212777d7608ae52904999d1f7fcaef96be59ebf",
    "flickering-v0": "93ff3d6f866bb4fdbffbcdf8e2ffce7d450b3a9770bb604c2d55d4385b2d28e2",
    "slippery-v0": "87133e53ca297ad316a5b274368590804b31019f18f36b253bb7e375b07f713f",
    "stop-line-dense-v1": "e8d33f5a56b205ea49d2ca92bcf969b02895e4e4890c2f96f846fe00ca684191",
    "stop-line-erratic-v1": "26a9c07e4ecb71942e51fd99778d56fdc823dbba33affde4a3019c4afdffb620",
    "stop-line-wet-v1": "eb2d964ccff3b963fa3b69616433e2f55814b26b4f786be70a28121bac2b306b",
    "stop-line-noisy-v1": "a76931b5037aefed674b07b310b3365052c4d6a41bd24faf22ff6031da56bc5d",
    "haunted-v0": "3534afe0e1036e3d3dbc4a6e932480bc9ba894b20ce5ebfcf685a8f7454c344a",
    "adversary-v0": "5b1a8a7eeecf015ec72d62300768afe8997d1e4bde4abc782b6c44e049f39624",
}


@pytest.mark.parametrize("scenario_id", KNOWN)
def test_trajectories_match_their_golden_digest(scenario_id: str) -> None:
    digest = trajectory_digest(KNOWN[scenario_id])
    said = f"{scenario_id} is new, or its trajectories changed (say so in the CHANGELOG): {digest}"
    assert digest == GOLDEN.get(scenario_id), said
