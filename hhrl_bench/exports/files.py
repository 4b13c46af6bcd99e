"""Columns as the content of a CSV or a Parquet file, or as a DataFrame; the same columns give the same bytes."""

import csv
import io
from collections.abc import Sequence
from typing import Any

from hhrl_bench.exports.episodes import TEXTS, Columns
from hhrl_envs.errors import require


def to_csv(columns: Columns) -> bytes:
    """Return columns as a CSV file in UTF-8 with a line of names; numbers have all of their digits, None is nothing."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*columns.values(), strict=True))
    return text.getvalue().encode()


def to_parquet(columns: Columns) -> bytes:
    """Return columns as a Parquet file; it needs the data extra."""
    require("pyarrow", "data")
    import pyarrow as pa  # noqa: PLC0415
    from pyarrow import parquet  # noqa: PLC0415

    kinds = {**dict.fromkeys(TEXTS, pa.string()), "training_seed": pa.int64(), "feasible": pa.bool_()}
    arrays = {name: pa.array(values, kinds.get(name) or _kind(pa, values)) for name, values in columns.items()}
    buffer = io.BytesIO()
    parquet.write_table(pa.table(arrays), buffer)
    return buffer.getvalue()


def to_frame(columns: Columns) -> Any:
    """Return columns as a pandas ``DataFrame``; it needs the data extra."""
    require("pandas", "data")
    import pandas as pd  # noqa: PLC0415

    frame = pd.DataFrame(columns)
    numbers = {name: "float64" for name in columns if frame[name].dtype == object and name not in TEXTS}
    kinds = {**numbers, "training_seed": "Int64", "feasible": "boolean"}
    return frame.astype({name: kind for name, kind in kinds.items() if name in columns})


def _kind(pa: Any, values: Sequence[Any]) -> Any:
    """Return the type of numbers: whole ones are int64; where all are unknown, float64."""
    return pa.int64() if values and all(isinstance(value, int) for value in values) else pa.float64()
