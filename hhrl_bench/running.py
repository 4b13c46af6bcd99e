"""Running: the units of a suite done stage by stage, and the curves that its transfers have left."""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from hhrl_bench.attempts import Done, unit_status
from hhrl_bench.board import Board
from hhrl_bench.executors import Execution, run_units
from hhrl_bench.overseer import Overseer, Show
from hhrl_bench.progress import silent
from hhrl_bench.training_outcomes import read_outcomes
from hhrl_bench.transfer import Transfer, sensible_arms
from hhrl_bench.transfer_records import TransferSetRecord
from hhrl_bench.transfer_rows import ArmCurves, TransferCurves, transfer_set
from hhrl_bench.units import Unit

Stages = Sequence[Sequence[Unit]]
"""Units in the order in which they can be done: those of a stage need what the stages before it have left."""


def run_stages(stages: Stages, execution: Execution, board: Board | None = None, show: Show = silent) -> Iterator[Done]:
    """Return every unit as it is done; after a stage in which one has failed the next ones are not begun.

    What becomes of the units stands on the board, if any; ``show`` hears how far the running ones are.

    Raises:
        InputError: before anything is done, if it is plain that a unit cannot be.
    """
    for stage in stages:
        for unit in stage:
            unit.check()
    with execution.pool(board) as pool:
        overseer = Overseer(board, show, execution.patience) if board else None
        for stage in stages:
            failed = False
            for done in run_units(stage, pool, overseer):
                failed |= done.outcome is None
                if board and done.lost:
                    board.write(unit_status(done, 0.0))
                yield done
            if failed:
                return


def transfer_record(transfers: Iterable[Transfer]) -> TransferSetRecord | None:
    """Return what the curves of finished transfers come to; None without a transfer.

    Raises:
        InputError: if a source or a curve is missing.
    """
    curves = [_curves(transfer) for transfer in transfers]
    return transfer_set(curves) if curves else None


def _curves(transfer: Transfer) -> TransferCurves:
    source = transfer.load()
    arms = {
        arm.id: _arm_curves(transfer.folder_of(arm.id), transfer.seeds)
        for arm in sensible_arms(source.method, transfer.target)
    }
    return TransferCurves(source.scenario, transfer.target.id, source.method.id, arms)


def _arm_curves(folder: Path, seeds: tuple[int, ...]) -> ArmCurves:
    """Return the curves of a run; a seed that failed succeeds no more from then on."""
    outcomes = read_outcomes(folder, seeds)
    success = tuple(tuple(rate or 0.0 for rate in curve) for curve in outcomes.testing.success)
    return ArmCurves(outcomes.seeds, outcomes.env_steps, success)
