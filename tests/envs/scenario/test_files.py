"""Scenario files: what is written is read again, to the same hash, and what is wrong is said in one line."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hhrl_envs import SCENARIOS, InputError, Option, ProfileFamily, Scenario, Simulator, Traffic, read_scenario
from hhrl_envs import scenario_from_json as from_json
from hhrl_envs import scenario_to_json as to_json
from hhrl_envs.scenario import files
from hhrl_envs.scenario.registry import add_scenario
from hhrl_envs.simulation.rewards import UNSAFE
from support.hidden import HIDDEN

MAIN = SCENARIOS["stop-line-v0"]


def changed(*place: str | int, value: Any) -> str:
    data = json.loads(to_json(MAIN))
    part = data
    for key in place[:-1]:
        part = part[key]
    part[place[-1]] = value
    return json.dumps(data)


@pytest.mark.parametrize("scenario", [*SCENARIOS.values(), *HIDDEN.values()], ids=lambda scenario: scenario.id)
def test_what_is_written_is_read_again_to_the_same_hash(scenario: Scenario, tmp_path: Path) -> None:
    path = tmp_path / "world.json"
    path.write_text(to_json(scenario))
    read = read_scenario(path)
    assert read == scenario
    assert read.spec_hash == scenario.spec_hash
    assert json.loads(to_json(scenario))["goal"] in {"STOP", "PASS", "FOLLOW"}


def test_what_is_left_out_has_its_default() -> None:
    families = [{"name": "calm", "weight": 1.0, "dwell": [1.0, 2.0]}]
    read = from_json(json.dumps({"id": "bare-v0", "traffic": {"families": families}}))
    assert read == Scenario("bare-v0", Traffic((ProfileFamily("calm", 1.0, dwell=(1.0, 2.0)),)))


def charged(scenario: Scenario) -> float:
    """What 50 egos that drive on at full throttle pay for being too fast to stop at the line."""
    simulator, charges = Simulator(scenario, 50), 0.0
    simulator.reset(np.arange(50))
    for _ in range(150):
        simulator.step(np.full(50, scenario.num_actions - 1))
        charges -= simulator.terms[:, UNSAFE[Option.SSL]].sum()
    return charges


def test_a_file_may_ask_for_the_printed_reward(tmp_path: Path) -> None:
    path = tmp_path / "printed.json"
    path.write_text(changed("reward", "unsafe", value="printed"))
    scenario = read_scenario(path)
    assert scenario == replace(MAIN, reward=replace(MAIN.reward, unsafe="printed"))
    assert from_json(to_json(scenario)) == scenario
    assert scenario.spec_hash != MAIN.spec_hash
    assert charged(scenario) > charged(MAIN) > 0.0


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[1]", "it is [1]; write an object with the keys id, traffic"),
        ("{}", "it lacks 'id'; add it"),
        ('{"id": "a-v0"}', "it lacks 'traffic'; add it"),
        ('{"id": "a", "id": "b"}', "the key 'id' is given twice; give it once"),
        ("{", "this is no JSON: "),
        ("[" * 100_000, "this is no JSON: "),
        ('{"id": NaN}', "NaN is no number; write a finite one"),
        ('{"dt": 1e999}', "it lacks 'id'"),
        (changed("frction", value=1.0), "has the unknown key 'frction'"),
        (changed("road", "frction", value=1.0), "road has the unknown key 'frction', did you mean 'friction'; write"),
        (changed("road", value=3), "road is 3; write an object with the keys speed_limit, "),
        (changed("road", "friction", value=7), "road.friction is 7; write a coefficient from 0.01 to 1.5"),
        (changed("road", "friction", value="1"), "road.friction is '1'; write a coefficient"),
        (changed("road", "friction", value=True), "road.friction is True; write a coefficient"),
        (changed("road", "lines", value=0.0), "road.lines is 0.0; write"),
        (changed("road", "start_speed", value=[5]), "road.start_speed is (5,); write a list (low, high) in m/s"),
        (changed("road", "slippery", value=0.3), "road.slippery is 0.3; write an object with the keys share, friction"),
        (changed("road", "slippery", value={"share": 1}), "road.slippery lacks 'friction'; add it"),
        (
            changed("road", "slippery", value={"share": 2, "friction": [0.1, 0.2]}),
            "road.slippery.share is 2; write a share from 0 to 1",
        ),
        (
            changed("sensor", "ghosts", value=0.3),
            "sensor.ghosts is 0.3; write an object with the keys share, stretch, near",
        ),
        (changed("sensor", "ghosts", value={"share": -1}), "sensor.ghosts.share is -1; write a share from 0 to 1"),
        (changed("sensor", "dropout", value=1.0), "sensor.dropout is 1.0; write a share from 0 to 0.95"),
        (changed("sensor", "dropout_time", value=0), "sensor.dropout_time is 0; write seconds from 0.001 to 1000"),
        (changed("dt", value=float("1e308") * 10), "Infinity is no number"),
        (changed("goal", value=0), "goal is 0; write one of: 'STOP', 'PASS', 'FOLLOW'"),
        (changed("goal", value=["STOP"]), "goal is ['STOP']; write one of"),
        (changed("signal", value={}), "signal lacks 'green_at'; add it"),
        (
            changed("traffic", "families", 0, "wait", value=1),
            "traffic.families[0] has the unknown key 'wait'",
        ),
        (changed("traffic", "families", 0, value=None), "traffic.families[0] is None; write an object"),
        (
            changed("traffic", "families", value=[]),
            "traffic.families is (); write a list of at least one ProfileFamily",
        ),
        (changed("id", value="../escape"), "id is '../escape'; write a name of letters"),
        (changed("horizon", value=10**30), "world.json: horizon is "),
        (changed("reward", "unsafe", value="literal"), "reward.unsafe is 'literal'; write one of: floored, printed"),
        (changed("reward", "unsafe", value=None), "reward.unsafe is None; write one of: floored, printed"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(text: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "world.json"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_scenario(path)
    assert said in str(caught.value)
    assert str(caught.value).startswith(f"{path}: ")
    assert len(str(caught.value).splitlines()) == 1


def test_files_that_are_none_are_said_in_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "world.json"
    with pytest.raises(InputError, match=r"cannot read .*world\.json: No such file or directory; name a scenario file"):
        read_scenario(path)
    with pytest.raises(InputError, match="cannot read "):
        read_scenario(tmp_path)
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match=r"world\.json is no text in UTF-8; name a scenario file"):
        read_scenario(path)
    monkeypatch.setattr(files, "LONGEST", 10)
    path.write_text(to_json(MAIN))
    with pytest.raises(InputError, match=r"world\.json has more than 10 bytes"):
        read_scenario(path)


def test_an_equal_scenario_does_not_take_the_place_of_a_registered_one() -> None:
    whole = replace(MAIN, road=replace(MAIN.road, friction=1))
    assert whole == MAIN
    assert whole.spec_hash != MAIN.spec_hash
    add_scenario(whole)
    assert SCENARIOS[MAIN.id].spec_hash == MAIN.spec_hash
