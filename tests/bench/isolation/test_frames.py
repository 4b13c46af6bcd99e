"""Frames between the harness and an agent's process: what one packs the other unpacks, and nothing is read beyond."""

import io

import numpy as np
import pytest

from hhrl_bench.isolation import frames

ROWS, WIDTH = 3, 11
EXAMPLES = {
    np.dtype(np.bool_): np.array([True, False, True]),
    np.dtype(np.int64): np.array([-1, 0, 2**40]),
    np.dtype(np.float32): np.arange(ROWS * WIDTH, dtype=np.float32).reshape(ROWS, WIDTH),
}


@pytest.mark.parametrize("name", frames.CALLS)
def test_a_call_comes_out_as_it_went_in(name: str) -> None:
    call = frames.CALLS[name]
    arrays = [EXAMPLES[column.dtype] for column in call.takes]
    request, rows, width = frames.request(call, arrays)
    stream = io.BytesIO(request)
    number, *sizes = frames.REQUEST.unpack(frames.read_exactly(stream, frames.REQUEST.size))
    assert frames.numbered(number) == (name, call)
    assert sizes == [rows, width] == [ROWS, WIDTH * call.takes[0].wide]
    data = frames.read_exactly(stream, frames.size(call.takes, rows, width))
    for before, after in zip(arrays, frames.unpack(call.takes, data, rows, width), strict=True):
        np.testing.assert_array_equal(before, after, strict=True)
        assert after.flags.writeable
    assert stream.read() == b""


def test_an_array_of_another_shape_is_not_packed() -> None:
    call = frames.CALLS["act_with_option"]
    with pytest.raises(ValueError, match="reshape"):
        frames.request(call, [EXAMPLES[np.dtype(np.float32)], np.zeros(ROWS + 1, np.int64)])


def test_a_stream_that_ends_early_is_an_error() -> None:
    with pytest.raises(EOFError):
        frames.read_exactly(io.BytesIO(b"abc"), 4)


def test_a_failure_is_cut_off() -> None:
    answer = frames.failure("x" * (2 * frames.LONGEST_TEXT))
    assert frames.ANSWER.unpack(answer[: frames.ANSWER.size]) == (frames.FAILED, frames.LONGEST_TEXT)
