"""Infos of fixed entries: the same names and shapes at reset and at every step, with the view's values."""

import warnings

import numpy as np
import pytest

from hhrl_envs import Outcome
from hhrl_envs.views.infos import NumericInfos
from hhrl_envs.views.parallel_env import EGO
from hhrl_envs.worlds import stop_line_v0

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    from pettingzoo.test import parallel_api_test


@pytest.mark.filterwarnings("ignore:We recommend agents:UserWarning")  # MPE's names, not a requirement
def test_pettingzoo_accepts_the_wrapped_view() -> None:
    parallel_api_test(NumericInfos(stop_line_v0.parallel_env()), num_cycles=200)


def test_entries_keep_their_names_and_shapes_and_values() -> None:
    wrapped, bare = NumericInfos(stop_line_v0.parallel_env()), stop_line_v0.parallel_env()
    _, infos = wrapped.reset(seed=1)
    shapes = {name: np.shape(value) for name, value in infos[EGO].items()}
    assert shapes == {"reward_option": (2,), "reward_action": (2,), "outcome": (), "is_success": ()}
    assert not any(np.any(value) for value in infos[EGO].values())
    bare.reset(seed=1)
    while wrapped.agents:
        infos, expected = wrapped.step({EGO: 5})[4], bare.step({EGO: 5})[4]
        assert {name: np.shape(value) for name, value in infos[EGO].items()} == shapes
        assert (infos[EGO]["reward_option"] == expected[EGO]["reward_option"]).all()
        assert infos[EGO]["outcome"] == expected[EGO].get("outcome", Outcome.RUNNING)
        assert infos[EGO]["is_success"] == (infos[EGO]["outcome"] == Outcome.SUCCESS)
    assert infos[EGO]["outcome"] != Outcome.RUNNING
