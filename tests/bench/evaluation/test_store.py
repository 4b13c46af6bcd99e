"""A store holds what its files' names say, and refuses everything else."""

import gzip
from pathlib import Path

import pytest

from hhrl_bench.errors import RecordError
from hhrl_bench.evaluation import store as stores
from hhrl_bench.evaluation.store import Store, read
from hhrl_bench.schema import sha256_of


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "store")


def test_what_is_added_is_read_and_lies_where_its_hash_says(store: Store) -> None:
    for add, find in ((store.add_evidence, store.evidence), (store.add_checkpoint, store.checkpoint)):
        sha256 = add(b"data")
        assert sha256 == sha256_of(b"data")
        assert read(find(sha256)) == b"data"
        assert find(sha256).is_relative_to(store.folder)


def test_adding_twice_writes_once_and_mends_what_was_damaged(store: Store) -> None:
    path = store.evidence(store.add_evidence(b"data"))
    before = path.stat().st_mtime_ns
    store.add_evidence(b"data")
    assert path.stat().st_mtime_ns == before
    path.write_bytes(gzip.compress(b"date"))
    store.add_evidence(b"data")
    assert read(path) == b"data"
    assert len(list(store.folder.rglob("*.gz"))) == 1


@pytest.mark.parametrize("other", [b"", b"Data", b"data ", b"dat"])
def test_another_content_or_another_name_is_refused(store: Store, other: bytes) -> None:
    evidence, checkpoint = store.evidence(store.add_evidence(b"data")), store.checkpoint(store.add_checkpoint(b"data"))
    renamed = checkpoint.with_name(f"{'0' * 64}.safetensors")
    renamed.write_bytes(b"data")
    checkpoint.write_bytes(other)
    evidence.write_bytes(gzip.compress(other))
    for changed in (evidence, checkpoint, renamed):
        with pytest.raises(RecordError, match="has been changed: the sha256 of what it holds is"):
            read(changed)


def test_evidence_is_the_same_however_it_is_compressed(store: Store) -> None:
    path = store.evidence(store.add_evidence(b"data" * 99))
    before = path.read_bytes()
    path.write_bytes(gzip.compress(b"data" * 99, compresslevel=0))
    assert path.read_bytes() != before
    assert read(path) == b"data" * 99


def test_evidence_that_is_not_one_whole_stream_is_refused(store: Store) -> None:
    path = store.evidence(store.add_evidence(b"data"))
    data = path.read_bytes()
    for other in (b"", data[:-1], data[: len(data) // 2], data + b"\0", data + data, b"data"):
        path.write_bytes(other)
        with pytest.raises(RecordError, match="has been changed: it ") as caught:
            read(path)
        assert len(str(caught.value).splitlines()) == 1


def test_a_bomb_is_not_unpacked(store: Store) -> None:
    path = store.evidence(store.add_evidence(b"\0" * 10**6))
    assert len(read(path)) == 10**6
    with pytest.raises(RecordError, match="it is not one gzip stream of at most 10,000 bytes"):
        read(path, 10_000)


def test_what_is_missing_or_too_large_is_refused(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    path = store.checkpoint(store.add_checkpoint(b"data"))
    monkeypatch.setattr(stores, "MAX_BYTES", 3)
    with pytest.raises(RecordError, match="is larger than 0 MiB"):
        read(path)
    with pytest.raises(RecordError, match="No such file"):
        read(store.checkpoint("0" * 64))


def test_a_copy_is_whole_or_not_made(store: Store, tmp_path: Path) -> None:
    path, other = store.evidence(store.add_evidence(b"data")), Store(tmp_path / "other")
    other.copy(path)
    assert read(other.evidence(sha256_of(b"data"))) == b"data"
    path.write_bytes(gzip.compress(b"date"))
    third = Store(tmp_path / "third")
    with pytest.raises(RecordError):
        third.copy(path)
    assert not third.folder.exists()
