"""The compiled value networks: those of the equations, and the same bits in any batch and on any processor."""

import hashlib
import os
import subprocess
import sys
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import torch

from hhrl_agents.networks import layers
from hhrl_agents.networks.architectures import Architecture, Attended
from hhrl_agents.networks.layers import ValueNetwork, flattened
from hhrl_agents.policies import checkpoints
from hhrl_agents.policies.checkpoint_file import SHIPPED
from hhrl_envs.arrays import Floats32, Ints
from hhrl_envs.observation import D_D, SIZE
from support import plain_networks

FLAT = Architecture(SIZE, (16, 12), 6)
ACTION = FLAT._replace(reads_option=True)
ATTENDING = ACTION._replace(attended=Attended.STATE)
ARCHITECTURES = {
    "flat": FLAT,
    "one hidden layer": FLAT._replace(hidden=(9,)),
    "flat with layer norm": FLAT._replace(layer_norm=True),
    "flat with memory": FLAT._replace(features=3 * SIZE),
    "hierarchical": ACTION,
    "attending": ATTENDING,
    "attending to the linear layer": ATTENDING._replace(attended=Attended.LINEAR),
    "attending with layer norm": ATTENDING._replace(attended=Attended.LINEAR, layer_norm=True),
    "attending with memory": ATTENDING._replace(features=3 * SIZE),
    "blind": ACTION._replace(sees_line=False),
    "blind and attending": ATTENDING._replace(sees_line=False, features=2 * SIZE, layer_norm=True),
}
EVERY = pytest.mark.parametrize("network", ARCHITECTURES.values(), ids=list(ARCHITECTURES))
FIGURE_2 = Architecture(SIZE, (64, 64), 6, reads_option=True, attended=Attended.LINEAR)
NORMALISED = Architecture(3 * SIZE, (128, 128), 6, layer_norm=True)


def parameters_of(network: Architecture) -> dict[str, Floats32]:
    rng = np.random.default_rng(1)
    return {name: rng.normal(0.0, 0.5, shape).astype(np.float32) for name, shape in network.shapes().items()}


def made(network: Architecture) -> ValueNetwork:
    return ValueNetwork(network, flattened([*parameters_of(network).values()]))


def inputs(network: Architecture, rows: int = 150) -> tuple[Floats32, Ints]:
    rng = np.random.default_rng(0)
    return rng.normal(size=(rows, network.features)).astype(np.float32), rng.integers(0, 2, rows)


def leaves(parameters: Mapping[str, Floats32]) -> plain_networks.Leaves:
    return {name: torch.from_numpy(value).double() for name, value in parameters.items()}


def one_hot(options: Ints) -> torch.Tensor:
    return torch.nn.functional.one_hot(torch.from_numpy(options), 2).double()


def plain_values(network: Architecture, states: Floats32, options: Ints) -> Floats32:
    """The values that the equations give, float64 [B, outputs]."""
    known, rows = leaves(parameters_of(network)), torch.from_numpy(states).double()
    if not network.reads_option:
        return plain_networks.mlp(known, rows, layer_norm=network.layer_norm).numpy()
    return plain_networks.action_values(
        known,
        rows,
        one_hot(options),
        attended=network.attended.name.lower(),
        layer_norm=network.layer_norm,
        sees_line=network.sees_line,
    ).numpy()


@EVERY
def test_values_are_those_of_the_equations(network: Architecture) -> None:
    states, options = inputs(network)
    before = states.copy()
    values = made(network).values(states, options)
    assert values.dtype == np.float32
    np.testing.assert_allclose(values, plain_values(network, states, options), rtol=1e-4, atol=1e-4)
    np.testing.assert_array_equal(states, before)


@EVERY
def test_a_row_has_the_same_bits_in_every_batch(network: Architecture) -> None:
    (states, options), compiled = inputs(network), made(network)
    together = compiled.values(states, options)
    for size in (1, 2, 3, 5, 64, 65, 149):
        parts = [compiled.values(states[i : i + size], options[i : i + size]) for i in range(0, len(states), size)]
        assert np.concatenate(parts).tobytes() == together.tobytes()
    every_other = compiled.values(states[::2], options[::2])
    assert every_other.tobytes() == together[::2].tobytes()


def test_threads_that_evaluate_at_once_give_the_same_bits() -> None:
    (states, options), compiled = inputs(ATTENDING, 2_000), made(ATTENDING)
    alone = compiled.values(states, options).tobytes()
    for threads in (2, 5):
        with ThreadPoolExecutor(threads) as pool:
            assert {value.tobytes() for value in pool.map(lambda _: compiled.values(states, options), range(20))} == {
                alone
            }


def test_a_network_finds_its_parameters_among_others() -> None:
    states, options = inputs(ATTENDING)
    row = flattened([*parameters_of(FLAT).values(), *parameters_of(ATTENDING).values()])
    first = sum(value.size for value in parameters_of(FLAT).values())
    np.testing.assert_array_equal(ValueNetwork(FLAT, row).values(states), made(FLAT).values(states))
    among = ValueNetwork(ATTENDING, row, first)
    np.testing.assert_array_equal(among.values(states, options), made(ATTENDING).values(states, options))
    np.testing.assert_array_equal(among.attention(states, options), made(ATTENDING).attention(states, options))


@pytest.mark.parametrize("attended", [Attended.STATE, Attended.LINEAR])
def test_attention_weighs_the_state_elements_of_the_option(attended: Attended) -> None:
    network = ATTENDING._replace(attended=attended)
    states, options = inputs(network)
    weights = made(network).attention(states, options)
    assert weights.shape == states.shape
    assert (weights > 0).all()
    np.testing.assert_allclose(weights.sum(1), 1.0, rtol=1e-5)
    assert np.abs(weights - made(network).attention(states, 1 - options)).max() > 1e-3
    known, rows = leaves(parameters_of(network)), torch.from_numpy(states).double()
    np.testing.assert_allclose(weights, plain_networks.attention(known, rows, one_hot(options)), atol=1e-6)


def test_attention_is_that_of_the_state_and_not_of_its_traces() -> None:
    network = ATTENDING._replace(features=3 * SIZE)
    states, options = inputs(network)
    elsewhere = states.copy()
    elsewhere[:, SIZE:] += 1.0
    weights = made(network).attention(states, options)
    np.testing.assert_array_equal(weights, made(network).attention(elsewhere, options))
    np.testing.assert_array_equal(weights, made(network).attention(states[:, :SIZE], options))


def test_without_attention_every_element_weighs_the_same() -> None:
    states, options = inputs(ACTION)
    np.testing.assert_array_equal(made(ACTION).attention(states, options), np.full_like(states, 1 / SIZE))


@pytest.mark.parametrize("network", [ACTION, ATTENDING._replace(features=2 * SIZE)])
def test_values_without_the_line_depend_on_no_element_of_it(network: Architecture) -> None:
    blind, seeing = made(network._replace(sees_line=False)), made(network)
    states, options = inputs(network, 9)
    for element in range(network.features):
        moved = states.copy()
        moved[:, element] += 5.0
        of_the_line = element % SIZE >= D_D
        assert np.array_equal(blind.values(moved, options), blind.values(states, options)) == of_the_line
        assert not np.array_equal(seeing.values(moved, options), seeing.values(states, options))
        if network.attended and element < SIZE:
            assert np.array_equal(blind.attention(moved, options), blind.attention(states, options)) == of_the_line


def digest() -> str:
    """Return the SHA-256 of what shipped and made-up networks give for some thousand states."""
    shipped = checkpoints.load(SHIPPED / "hybrid-hrl" / "seed-0.safetensors")
    networks = [(level, shipped._networks[level]) for level in ("option", "action")]
    networks += [("figure 2", made(FIGURE_2)), ("layer norm", made(NORMALISED))]
    found = hashlib.sha256()
    for _, network in networks:
        states, options = inputs(network._architecture, 4_000)
        found.update(network.values(states, options).tobytes())
        found.update(network.attention(states[:500, :SIZE], options[:500]).tobytes())
    return found.hexdigest()


@pytest.mark.parametrize("processor", ["x86-64", "haswell"])
def test_another_processor_gives_the_same_bits(processor: str, tmp_path: Path) -> None:
    environment = {
        **os.environ,
        "NUMBA_CPU_NAME": processor,
        "NUMBA_CPU_FEATURES": "",
        "NUMBA_CACHE_DIR": str(tmp_path),
        "PYTHONPATH": os.pathsep.join(sys.path),
    }
    code = "from agents.networks.test_layers import digest; print(digest())"
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == digest()
    assert list(tmp_path.rglob("*.nbi")), "nothing was compiled anew"


def test_a_layout_leaves_no_gap_and_no_overlap() -> None:
    for network in ARCHITECTURES.values():
        layout, width = layers.layout_of(network)
        rows = layout[0 if network.attended else 1 :]
        blocks = [(0, network.features), *((row[layers.INPUTS], row[layers.FAN_IN]) for row in rows)]
        last = layout[-1]
        blocks.append((last[layers.OUTPUTS], last[layers.FAN_OUT]))
        if network.attended:
            blocks.append((layout[0, layers.SCORED], SIZE))
        if network.layer_norm:
            for row in layout[1:-1]:
                blocks += [(row[layers.NORMS], row[layers.FAN_OUT]), (row[layers.FACTORS], 1)]
        blocks.sort()
        assert all(start + size == after for (start, size), (after, _) in pairwise(blocks))
        assert blocks[-1][0] + blocks[-1][1] == width
