"""Calibrate: search for the paper's world or take the registered one, score it, write the files."""

from pathlib import Path

from hhrl_agents.atomic_files import require_writable, write_atomically
from hhrl_bench.calibration import residuals, space
from hhrl_bench.calibration.fit import fit
from hhrl_bench.calibration.residuals import ParametersRecord, ResidualsRecord
from hhrl_bench.progress import Update
from hhrl_bench.provenance import provenance
from hhrl_bench.schema import SCHEMA_VERSION, Record
from hhrl_bench.tasks.tasks import TEST
from hhrl_envs import Scenario, get_scenario

FIT_EPISODES = 1_200
PARAMETERS, RESIDUALS, PAGE = "parameters.json", "residuals.json", "residuals.md"


def search(seed: int, generations: int, episodes: int, folder: Path | None, update: Update) -> ResidualsRecord:
    """Return the residuals of the best world found; write its parameters and its residuals into the folder, if any.

    Raises:
        SeedError, OutputError: before the search, if its outcome could not be scored or written.
    """
    TEST.take(episodes)
    if folder is not None:
        require_writable(folder / PARAMETERS)
    command = f"hhrl-bench calibrate --seed {seed} --generations {generations}"
    found = fit(seed, generations, FIT_EPISODES, update)
    scenario = space.build(found.parameters)
    record = ParametersRecord(
        schema_version=SCHEMA_VERSION,
        scenario=scenario.id,
        spec_hash=scenario.spec_hash,
        seed=seed,
        generations=generations,
        episodes=FIT_EPISODES,
        worlds=found.worlds,
        objective=found.objective,
        parameters=found.parameters,
        provenance=provenance(command, {}),
    )
    if folder is not None:
        _write(record, folder / PARAMETERS)
    return _publish(scenario, episodes, folder, f"{command} --episodes {episodes}")


def check(episodes: int, folder: Path | None) -> ResidualsRecord:
    """Return the residuals of the registered world; write them into the folder, if any."""
    return _publish(
        get_scenario(space.SCENARIO_ID), episodes, folder, f"hhrl-bench calibrate --check --episodes {episodes}"
    )


def _publish(scenario: Scenario, episodes: int, folder: Path | None, command: str) -> ResidualsRecord:
    if folder is not None:
        require_writable(folder / RESIDUALS)
    record = residuals.measure(scenario, episodes, command)
    if folder is not None:
        _write(record, folder / RESIDUALS)
        write_atomically(folder / PAGE, residuals.markdown(record))
    return record


def _write(record: Record, path: Path) -> None:
    write_atomically(path, record.model_dump_json(indent=2) + "\n")
