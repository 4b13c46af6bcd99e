"""A third sub-goal needs its declaration and its kernels, nothing else of the environments."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np

import hhrl_envs
from hhrl_envs import Simulator

SCENARIO, ROWS, STEPS = "stop-line-noisy-v0", 8, 60

DECLARATION = """
KSL = SubGoal(
    option=Option.KSL,
    name="keep",
    title="keep the speed limit",
    exists=_has_line,
    elements=(
        Element("d_k", "m/s", _SPEED, "-", "speed limit - v_e", noise="speed"),
        Element("d_kc", "m/s", _SPEED, "-", "d_k - d_ks, with d_ks = 4 m/s"),
        Element("d_kc/d_ks", "1", _RATIO, "[-1, 10]", "the same as a share of d_ks"),
    ),
    distance="d_k",
    critical="d_kc",
    ratio="d_kc/d_ks",
    failure=Outcome.SPEEDING,
    failure_title="SPEEDING",
    failure_colour=(0, 0, 0),
    target=None,
    colour=(86, 180, 233),
)

"""

KERNEL = """
D_K, D_KC, KC_RATIO = map(at.measured, ("d_k", "d_kc", "d_kc/d_ks"))


@inner
def safety_keep(m, s, c):
    return 4.0


@inner
def derive_keep(m, s, c):
    d_kc = m[s + D_K] - 4.0
    m[s + D_KC], m[s + KC_RATIO] = d_kc, min(max(d_kc / 4.0, RATIO_LOW), RATIO_HIGH)


@inner
def measure_keep(m, s, c, lanes):
    for i in range(lanes):
        m[s + D_K + i] = c[at.SPEED_LIMIT] - m[s + at.SPEED + i]
        derive_keep(m, s + i, c)


@spliced
def failed_keep(m, s):
    return m[s + D_K] < -1.0


@spliced
def penalty_keep(m, s, sigma_3):
    return -m[s + at.V_E]


def bounds_keep(scenario, motion):
    high = scenario.road.speed_limit + 6.0 * scenario.sensor.noise_speed
    return (-high, high), (-high - 4.0, high - 4.0), (RATIO_LOW, RATIO_HIGH)


"""

CODE = f"""if True:
    import sys
    import numpy as np
    from hhrl_envs import Option, Outcome, Simulator, triad
    from hhrl_envs.rendering.renderer import draw_row
    from hhrl_envs.simulation import rewards

    rng = np.random.default_rng(1)
    simulator = Simulator("{SCENARIO}", {ROWS})
    simulator.reset(np.arange({ROWS}))
    shown, charged = [simulator.observations], False
    for _ in range({STEPS}):
        simulator.step(rng.integers(1, 6, {ROWS}))
        terms, option, action = simulator.terms, simulator.reward_option, simulator.reward_action
        sr = terms[:, [rewards.TIME, rewards.TIMEOUT, rewards.SUCCESS]].sum(axis=1)
        assert option.shape == action.shape == ({ROWS}, 3)
        np.testing.assert_allclose(option + action - sr[:, None], simulator.rewards[:, None].repeat(3, 1), atol=1e-9)
        own = terms[:, rewards.UNSAFE] + terms[:, rewards.FAILURE]
        np.testing.assert_allclose(action, (sr + terms[:, rewards.UNSMOOTH])[:, None] + own, atol=1e-9)
        charged |= (own[:, 2] != 0.0).any()
        shown.append(simulator.observations)
    assert charged
    assert rewards.TERMS[4:8] == ("UNSAFE_KSL", "COLLISION", "NOT_STOP", "SPEEDING")
    np.save(sys.argv[1], np.array(shown))

    env = triad("{SCENARIO}").parallel_env()
    observations, infos = env.reset(seed=0)
    assert infos["ego"]["option_mask"].tolist() == [True, True, True]
    observations, *_, infos = env.step({{"ego": 3}})
    assert env.observation_space("ego").contains(observations["ego"])
    assert infos["ego"]["reward_option"].shape == (3,)
    env.show_option(Option.KSL)
    assert draw_row(simulator, option=Option.KSL).any()
"""


def insert(path: Path, *edits: tuple[str, str]) -> None:
    """Put a text in front of another one, which must be there once."""
    text = path.read_text()
    for before, new in edits:
        assert text.count(before) == 1, before
        text = text.replace(before, new + before)
    path.write_text(text)


def add_third_sub_goal(package: Path) -> None:
    """Add the sub-goal KSL, "keep the speed limit", in the two files that a sub-goal has in the environments."""
    insert(
        package / "sub_goals.py",
        ("\n\nclass Outcome(", "    KSL = 2\n"),
        ("\n\nRUNNING, COLLISION", "    SPEEDING = 7\n"),
        (" = (float(outcome)", ", SPEEDING"),
        ("SUB_GOALS = (", DECLARATION.lstrip()),
        (')\n"""All sub-goals, in the order of their options."""', ", KSL"),
        (')\n"""All sub-goals in the order of their elements', ", KSL"),
    )
    functions = "Kernels(measure_keep, safety_keep, derive_keep, failed_keep, penalty_keep, bounds_keep)"
    insert(
        package / "simulation" / "sub_goal_kernels.py",
        ("_BY_OPTION: Mapping", KERNEL.lstrip()),
        ("}\nKERNELS = tuple(", f"    Option.KSL: {functions},\n"),
    )


def test_a_third_sub_goal_is_a_declaration_and_its_kernels(tmp_path: Path) -> None:
    package = tmp_path / "hhrl_envs"
    shutil.copytree(Path(hhrl_envs.__file__).parent, package, ignore=shutil.ignore_patterns("__pycache__"))
    add_third_sub_goal(package)
    told = tmp_path / "observations.npy"
    environment = {**os.environ, "PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "kernels")}
    command = [sys.executable, "-c", CODE, str(told)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment, cwd=tmp_path)
    assert done.returncode == 0, done.stderr

    rng, simulator = np.random.default_rng(1), Simulator(SCENARIO, ROWS)
    simulator.reset(np.arange(ROWS))
    shown = [simulator.observations]
    for _ in range(STEPS):
        simulator.step(rng.integers(1, 6, ROWS))
        shown.append(simulator.observations)
    observations = np.load(told)
    assert observations.shape == (STEPS + 1, ROWS, 14)
    assert observations[:, :, :11].tobytes() == np.array(shown).tobytes()
    assert (observations[:, :, 11] != 0.0).any()
