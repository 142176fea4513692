"""Mutations of a file's bytes, seeded."""

from __future__ import annotations

import re

import numpy as np

_NUMBERS = (b"nan", b"inf", b"-1", b"0", b"1e308", b"1000000000000", b"true", b'"text"', b"[]", b"-0.5")
_NUMBER = re.compile(rb"(?<![\w.])-?\d+(?:\.\d+)?(?![\w.])")
TEXTS = (".usda", ".yaml")


def mutated(data: bytes, suffix: str, draw: np.random.Generator) -> tuple[str, bytes]:
    """Return what was done to a file, and the bytes that came of it."""
    ways = [_flip, _truncate, _double, _exchange, _garble]
    if suffix in TEXTS:
        ways += [_number, _number, _drop_line, _double_line, _word, _empty]
    for _ in range(20):
        way = ways[int(draw.integers(len(ways)))]
        changed = way(data, draw)
        if changed != data:
            return way.__name__.lstrip("_"), changed
    return "truncate", data[:-1]


def _place(data: bytes, draw: np.random.Generator) -> int:
    return int(draw.integers(len(data)))


def _flip(data: bytes, draw: np.random.Generator) -> bytes:
    found = bytearray(data)
    for _ in range(int(draw.choice([1, 1, 2, 10, 100]))):
        found[_place(data, draw)] ^= 1 << int(draw.integers(8))
    return bytes(found)


def _garble(data: bytes, draw: np.random.Generator) -> bytes:
    place, size = _place(data, draw), int(draw.integers(1, 40))
    return data[:place] + draw.bytes(size) + data[place + size :]


def _truncate(data: bytes, draw: np.random.Generator) -> bytes:
    return data[: _place(data, draw)]


def _double(data: bytes, draw: np.random.Generator) -> bytes:
    place, size = _place(data, draw), int(draw.integers(1, 200))
    return data[: place + size] + data[place:]


def _exchange(data: bytes, draw: np.random.Generator) -> bytes:
    size = int(draw.integers(1, max(2, len(data) // 4)))
    one, other = sorted((_place(data, draw), _place(data, draw)))
    if other - one < size:
        return data
    return (
        data[:one]
        + data[other : other + size]
        + data[one + size : other]
        + data[one : one + size]
        + data[other + size :]
    )


def _number(data: bytes, draw: np.random.Generator) -> bytes:
    found = list(_NUMBER.finditer(data))
    if not found:
        return data
    chosen = found[int(draw.integers(len(found)))]
    return data[: chosen.start()] + _NUMBERS[int(draw.integers(len(_NUMBERS)))] + data[chosen.end() :]


def _line(data: bytes, draw: np.random.Generator, times: int) -> bytes:
    lines = data.splitlines(keepends=True)
    place = int(draw.integers(len(lines)))
    return b"".join([*lines[:place], *[lines[place]] * times, *lines[place + 1 :]])


def _drop_line(data: bytes, draw: np.random.Generator) -> bytes:
    return _line(data, draw, 0)


def _double_line(data: bytes, draw: np.random.Generator) -> bytes:
    return _line(data, draw, int(draw.integers(2, 50)))


def _word(data: bytes, draw: np.random.Generator) -> bytes:
    words = list(re.finditer(rb"[A-Za-z_]{3,}", data))
    one, other = (words[int(draw.integers(len(words)))] for _ in range(2))
    return data[: one.start()] + other[0] + data[one.end() :]


def _empty(data: bytes, draw: np.random.Generator) -> bytes:
    return b"" if draw.random() < 0.3 else data
