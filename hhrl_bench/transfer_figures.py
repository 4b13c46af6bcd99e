"""The figures of a transfer study, by name. Needs the ``report`` extra."""

from itertools import groupby
from pathlib import Path

from hhrl_bench.figures import save, style
from hhrl_bench.transfer_curves_figure import draw_transfer_curves
from hhrl_bench.transfer_matrix_figure import draw_transfer_matrix
from hhrl_bench.transfer_records import TransferSetRecord


def save_transfer_figures(record: TransferSetRecord, folder: Path) -> list[Path]:
    """Return the files written, SVG and PNG: the curves of every method and source, and the matrix of every method.

    Raises:
        OutputError: if one cannot be written.
    """
    written: list[Path] = []
    rows = sorted(record.rows, key=lambda row: row.group)
    with style():
        for method, own in groupby(rows, key=lambda row: row.method):
            matrix = list(own)
            for source, curves in groupby(matrix, key=lambda row: row.source):
                written += save(draw_transfer_curves(list(curves)), folder, f"transfer-curves-{method}-{source}")
            written += save(draw_transfer_matrix(matrix), folder, f"transfer-matrix-{method}")
    return written
