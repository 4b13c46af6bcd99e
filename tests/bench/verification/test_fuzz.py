"""Whatever is read may be hostile: it is said in one line, nothing is executed or written outside; see `make fuzz`."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

pytest.importorskip("torch")

from support import fuzzing
from support.fuzzing import ATTACKS, Sandbox


@pytest.fixture(scope="module")
def sandbox(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Sandbox]:
    with fuzzing.quick_statistics(), fuzzing.unchecked(), pytest.MonkeyPatch.context() as patch:
        sandbox = fuzzing.make_sandbox(tmp_path_factory.mktemp("sandbox"))
        patch.chdir(sandbox.folder)
        yield sandbox


@pytest.mark.parametrize("name", ATTACKS)
@settings(deadline=None, max_examples=25, database=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(seed=st.integers(0, 2**32))
def test_hostile_input_is_one_line_and_does_nothing(sandbox: Sandbox, name: str, seed: int) -> None:
    fuzzing.fuzz(sandbox, name, seed)


def test_the_watch_sees_what_must_not_happen(sandbox: Sandbox, tmp_path: Path) -> None:
    before = len(fuzzing.WATCH.deeds)
    with fuzzing.WATCH.over(sandbox.folder):
        (sandbox.folder / "inside").touch()
        (tmp_path / "outside").touch()
        eval("0")  # noqa: S307 - it is what is to be seen
    assert [deed.split()[0] for deed in fuzzing.WATCH.deeds[before:]] == ["open", "compile", "exec"]
    del fuzzing.WATCH.deeds[before:]
