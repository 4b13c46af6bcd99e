from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hhrl_agents import RULES
from hhrl_bench.calibration import fit as calibration
from hhrl_bench.calibration import space, target
from hhrl_bench.calibration.calibrate import (
    PAGE,
    PARAMETERS,
    RESIDUALS,
    ParametersRecord,
    ResidualsRecord,
    markdown,
)
from hhrl_bench.calibration.fit import Fit, fit, score
from hhrl_bench.evaluation.metrics import means
from hhrl_bench.evaluation.paired_evaluation import play
from hhrl_bench.tasks.tasks import TEST, VALIDATION
from hhrl_envs import SCENARIOS, get_scenario
from support.command_line import invoke

FOLDER = Path(__file__).parents[3] / "leaderboards" / "calibration"
PUBLISHED = ResidualsRecord.model_validate_json((FOLDER / RESIDUALS).read_bytes())
FOUND = ParametersRecord.model_validate_json((FOLDER / PARAMETERS).read_bytes())
WORLD = get_scenario(space.SCENARIO_ID)


def test_the_published_residuals_are_of_the_registered_scenario_and_every_bar_holds() -> None:
    assert PUBLISHED.spec_hash == WORLD.spec_hash
    assert PUBLISHED.episodes == 10_000
    ours = np.array([cell.ours for cell in PUBLISHED.cells]).reshape(target.paper().shape)
    low, high = target.bars()
    assert (~np.isnan(low)).sum() == 20
    assert not (ours < low).any()
    assert not (ours > high).any()
    assert PUBLISHED.holds


def test_the_published_page_says_what_the_published_residuals_hold() -> None:
    assert (FOLDER / PAGE).read_text() == markdown(PUBLISHED)


def test_the_registered_scenario_is_the_one_that_the_search_found() -> None:
    assert space.build(FOUND.parameters) == WORLD
    assert FOUND.spec_hash == WORLD.spec_hash
    for parameter in space.SPACE:
        assert parameter.low <= FOUND.parameters[parameter.name] <= parameter.high, parameter.name


def test_the_interface_is_that_of_every_other_scenario() -> None:
    assert {scenario.interface_hash for scenario in SCENARIOS.values()} == {WORLD.interface_hash}
    assert WORLD.feasible_only
    sigma = (WORLD.reward.sigma_1, WORLD.reward.sigma_2, WORLD.reward.sigma_3, WORLD.reward.sigma_4)
    assert sigma == (0.01, 2.5, 36.0, 49.0)


def test_the_rates_hold_on_episodes_that_nobody_has_seen() -> None:
    episodes = 2_000
    ours, (low, high) = score(WORLD, TEST.take(episodes, offset=10**6)), target.bars()
    rates = [target.COLUMNS.index(column) for column in target.RATES]
    chance = 3.0 * np.sqrt(0.25 / episodes)
    assert (ours[:, rates] >= low[:, rates] - chance).all()
    assert (ours[:, rates] <= high[:, rates] + chance).all()


def test_a_score_is_what_the_evaluation_says() -> None:
    seeds = TEST.take(50)
    for row, ours in zip(target.ROWS, score(WORLD, seeds), strict=True):
        evaluated = means(play(RULES[row.counterpart](WORLD), WORLD, seeds).records)
        np.testing.assert_allclose(ours, [evaluated[column] for column in target.COLUMNS], rtol=1e-12)


def test_the_objective_is_0_at_table_i_and_grows_steeply_past_a_bar() -> None:
    paper, (low, _) = target.paper(), target.bars()
    assert target.objective(paper) == 0.0
    rule_4, success = 3, target.COLUMNS.index("success")
    inside, outside = paper.copy(), paper.copy()
    inside[rule_4, success] = 0.5 * (paper[rule_4, success] + low[rule_4, success])
    outside[rule_4, success] = low[rule_4, success] - 0.05
    assert target.objective(inside) == pytest.approx(0.25)
    assert target.objective(outside) > 10.0


def test_a_search_improves_on_its_guess_and_repeats_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    middle = np.array([(parameter.low + parameter.high) / 2.0 for parameter in space.SPACE])
    monkeypatch.setattr(space, "guess", lambda: middle)
    monkeypatch.setattr(calibration, "POPULATION", 1)

    def search(generations: int) -> tuple[Fit, list[str]]:
        heard: list[str] = []
        return fit(3, generations, episodes=5, update=lambda *said: heard.append(said[2])), heard

    def worth(parameters: Mapping[str, float]) -> float:
        return target.objective(score(space.build(parameters), VALIDATION.take(5)))

    found, heard = search(3)
    assert found.objective == worth(found.parameters)
    assert found.objective < 0.9 * worth(space.named(middle))
    assert found.worlds == 4 * len(space.SPACE)
    assert heard[-1] == f"objective {found.objective:.2f}"
    assert search(1)[1] == heard[:1]


@pytest.mark.parametrize("corner", ["low", "high"])
def test_the_corners_of_the_space_are_worlds(corner: str) -> None:
    values = space.named(np.array([getattr(parameter, corner) for parameter in space.SPACE]))
    world = space.build(values)
    assert world.id == space.SCENARIO_ID
    assert world.vehicle.levels == WORLD.vehicle.levels


def test_check_scores_the_registered_scenario_and_writes_both_files(tmp_path: Path) -> None:
    result = invoke("calibrate", "--check", "--episodes", "1000", "--out", str(tmp_path))
    record = ResidualsRecord.model_validate_json((tmp_path / RESIDUALS).read_bytes())
    assert result.exit_code == (0 if record.holds else 1), result.stderr
    assert record.spec_hash == WORLD.spec_hash
    assert result.stdout.strip() == (tmp_path / PAGE).read_text().strip()


def test_check_exits_1_where_a_bar_does_not_hold(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mild = replace(get_scenario("solo-stop-v0"), id=space.SCENARIO_ID)
    monkeypatch.setattr("hhrl_bench.calibration.calibrate.get_scenario", lambda _: mild)
    result = invoke("calibrate", "--check", "--episodes", "20", "--out", str(tmp_path))
    assert result.exit_code == 1
    assert "| rule-2 | collision | 89.0% | 0.0% | -89.0% | 81.4% to 93.7% | no |" in result.stdout


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--episodes", "0"), "cannot take 0 test seeds"),
        (("--episodes", "100001", "--check"), "ask for 1 to 100000"),
        (("--generations", "0"), "'--generations'"),
        (("--seed", "-1"), "'--seed'"),
        (("--out", __file__), "name another path"),
    ],
)
def test_bad_usage_is_refused_in_one_line_before_the_search(arguments: tuple[str, ...], words: str) -> None:
    result = invoke("calibrate", *arguments)
    assert result.exit_code == 2
    assert words in result.stderr
    assert len(result.stderr.splitlines()) == 1
