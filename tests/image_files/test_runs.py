"""Zlib streams of runs: zlib reads them back, whatever the bytes; nothing but the bytes decides what is written."""

import hashlib
import threading
import zlib

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from usdsdg.image_files import runs

pieces = st.lists(st.tuples(st.integers(0, 255), st.integers(1, 700)), min_size=1, max_size=60)


def joined(parts) -> np.ndarray:
    values, counts = zip(*parts)
    return np.repeat(np.array(values, np.uint8), counts)


def check(data: np.ndarray) -> bytes:
    for distance in (2, 3, 4):
        assert zlib.decompress(runs.compress(data, distance=distance)) == data.tobytes()
    packed = runs.compress(data)
    assert zlib.decompress(packed) == data.tobytes()
    return packed


def test_repetitions_are_found_at_their_distance():
    data = np.tile(np.arange(4, dtype=np.uint8), 10_000)
    sizes = [len(runs.compress(data, distance=distance)) for distance in (1, 2, 3, 4)]
    assert sizes[3] < 200 < 9000 < min(sizes[:3])


@given(pieces)
@settings(deadline=None)
@example([(0, 1)])
@example([(7, 2), (9, 259), (7, 3), (7, 258), (1, 260)])
def test_zlib_reads_runs(parts):
    check(joined(parts))


@given(st.binary(min_size=1, max_size=400))
@settings(deadline=None)
def test_zlib_reads_any_bytes(data):
    check(np.frombuffer(data, np.uint8))


@pytest.mark.parametrize("length", range(1, 300))
def test_zlib_reads_a_run_of_any_length_between_others(length):
    check(joined([(1, 1), (2, length), (3, 1), (4, length)]))


@pytest.mark.parametrize("extra", [-9, -1, 0, 1, 9])
@pytest.mark.parametrize("kinds", [1, 3, 256])
def test_runs_may_cross_the_ends_of_blocks(kinds, extra):
    data = np.random.default_rng(kinds).integers(0, kinds, 2 * runs.BLOCK + extra).astype(np.uint8)
    data[runs.BLOCK - 20 : runs.BLOCK + 30] = 5
    check(data)


def test_codes_are_cut_where_they_would_be_too_long():
    """Counts in Fibonacci's sequence have the longest codes: 25 bits for these."""
    counts = [1, 1]
    while sum(counts) + sum(counts[-2:]) < runs.BLOCK:
        counts.append(sum(counts[-2:]))
    data = np.repeat(np.arange(len(counts), dtype=np.uint8), counts)
    assert len(counts) > 20
    check(np.random.default_rng(0).permutation(data))


def test_bytes_of_a_size_near_their_entropy():
    data = np.random.default_rng(0).binomial(40, 0.5, 500_000).astype(np.uint8)
    shares = np.bincount(data)[np.bincount(data) > 0] / len(data)
    entropy = -(shares * np.log2(shares)).sum() / 8 * len(data)
    assert len(check(data)) < 1.02 * entropy
    assert len(check(np.zeros(1_000_000, np.uint8))) < 1500  # a bit or two for each 258, and four heads


def test_the_bytes_of_the_past_are_those_of_today():
    """They are the same on every machine: this digest is not made by the machine that runs the test."""
    y, x = np.mgrid[0:200, 0:300]
    image = np.stack([x // 3, y // 5 * (x > 99), x * y // 64], -1).astype(np.uint8)
    assert hashlib.sha256(runs.compress(image)).hexdigest() == DIGEST


DIGEST = "1d7d5b4d8f1acd706d61f39bd672bb41e9e971980943d86a77c76207f362f2d7"


def test_what_a_thread_compressed_before_changes_no_byte():
    generator = np.random.default_rng(3)
    pictures = [generator.integers(0, 2 + 5 * k, 4000 + 999 * k).astype(np.uint8) for k in range(20)]
    expected = [runs.compress(each) for each in pictures]
    found = {}

    def work(name: int) -> None:
        order = np.random.default_rng(name).permutation(len(pictures)).tolist()
        found[name] = {k: runs.compress(pictures[k]) for k in order}

    threads = [threading.Thread(target=work, args=(name,)) for name in range(8)]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    assert all(found[name][k] == expected[k] for name in range(8) for k in range(len(pictures)))


def test_scratch_is_filled_before_it_is_read():
    data = np.random.default_rng(4).integers(0, 9, 5000).astype(np.uint8)
    expected = runs.compress(data)
    for each in runs._scratch():
        each.numpy()[...] = 77
    assert runs.compress(data) == expected


def test_no_bytes_are_refused():
    with pytest.raises(ValueError, match="no bytes"):
        runs.compress(np.zeros(0, np.uint8))
