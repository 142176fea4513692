"""Counter-based random numbers, from which all nodes draw.

A draw is a pure function of (seed, node key, execution, prim path, component), so no generator is shared, and adding,
removing or reordering randomizers does not change any other draw. The mixing function is SplitMix64's finalizer
(Steele, Lea and Flood, OOPSLA 2014), applied once per element of the key.
"""

import hashlib
import operator
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from usdsdg.errors import GraphError
from usdsdg.session.session import current

_WORD = 0xFFFFFFFFFFFFFFFF
_GOLDEN, _MIX_1, _MIX_2 = 0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB
# The same for arrays: NumPy takes arrays of no dimension in half the time of scalars.
_GOLDEN_64, _MIX_1_64, _MIX_2_64 = (np.array(each, np.uint64) for each in (_GOLDEN, _MIX_1, _MIX_2))
_30, _27, _31, _11 = (np.array(each, np.uint64) for each in (30, 27, 31, 11))


@lru_cache(maxsize=1 << 17)
def hash_text(text: str) -> int:
    """Return a 64-bit hash of a string that is the same in every process."""
    return int.from_bytes(hashlib.blake2b(text.encode(), digest_size=8).digest(), "little")


def _mixed(state: int, part: int) -> int:
    """Fold `part` into `state`; both are 64 bits."""
    z = ((state ^ part) + _GOLDEN) & _WORD
    z = (z ^ (z >> 30)) * _MIX_1 & _WORD
    z = (z ^ (z >> 27)) * _MIX_2 & _WORD
    return z ^ (z >> 31)


def _mixed_array(state: np.ndarray, part: np.ndarray) -> np.ndarray:
    """`_mixed` of uint64 arrays, which are broadcast against each other."""
    z = state ^ part
    z += _GOLDEN_64
    shifted = z >> _30
    z ^= shifted
    z *= _MIX_1_64
    z ^= np.right_shift(z, _27, out=shifted)
    z *= _MIX_2_64
    z ^= np.right_shift(z, _31, out=shifted)
    return z


@lru_cache(maxsize=1 << 12)
def _node_state(seed: int, node: str) -> int:
    return _mixed(_mixed(0, seed & _WORD), hash_text(node))


def _state(seed: int, node: str, execution: int) -> int:
    return _mixed(_node_state(seed, node), execution & _WORD)


# Nodes draw for the same prims again and again.
@lru_cache(maxsize=1 << 10)
def _hashes(prims: tuple[str, ...]) -> np.ndarray:
    return np.array([hash_text(prim) for prim in prims], dtype=np.uint64)


@lru_cache(maxsize=64)
def _columns(components: int) -> np.ndarray:
    return np.arange(components, dtype=np.uint64)


def uniforms(seed: int, node: str, execution: int | np.ndarray, prims: Sequence[str], components: int) -> np.ndarray:
    """Draw independent uniform numbers.

    Args:
        seed: The global seed, or that of the node.
        node: Key of the drawing node (see `Node.key`).
        execution: Number of earlier executions of the node, or an array of these numbers.
        prims: One key for each row, usually the target prims' paths.
        components: Numbers per prim.

    Returns:
        (len(prims), components) float64 in [0, 1), with 53 random bits each; (executions, len(prims), components) for
        an array of executions.
    """
    if isinstance(execution, np.ndarray):
        node_state = np.array(_node_state(seed, node), np.uint64)
        state = _mixed_array(node_state, execution.astype(np.uint64))[:, None]
    else:
        state = np.array(_state(seed, node, execution), np.uint64)
    per_prim = _mixed_array(state, _hashes(tuple(prims)))
    bits = _mixed_array(per_prim[..., None], _columns(components))
    bits >>= _11
    return bits * 2.0**-53


def generator(seed: int, node: str, execution: int, *parts: str) -> np.random.Generator:
    """Return a NumPy generator for one execution of one node, for draws of unknown length (rejection, shuffles)."""
    state = _state(seed, node, execution)
    for part in parts:
        state = _mixed(state, hash_text(part))
    return np.random.Generator(np.random.Philox(key=state))


def own_seed(seed: Any) -> int | None:
    """Return the seed of a node from its `seed` argument; None, also for negative numbers, means the global seed.

    Raises:
        GraphError: (a ValueError) `seed` is not an integer.
    """
    number = None if seed is None else _whole("seed", seed, "a whole number, or None for the global seed")
    return None if number is None or number < 0 else number


def _whole(name: str, value: Any, expected: str) -> int:
    try:
        return operator.index(value)
    except TypeError:
        raise GraphError(f"{name} is {value!r}; expected {expected}") from None


class GlobalSeed:
    """The seed of the session; None until one is set or needed."""

    def __init__(self) -> None:
        self.value: int | None = None

    def follow_setting(self, seed: Any) -> None:
        """Take the value of the setting `/omni/replicator/globalSeed`; a negative value lets a seed be drawn."""
        self.value = own_seed(seed)


def set_global_seed(seed: int) -> None:
    """Set the global seed, which is also the setting `/omni/replicator/globalSeed`. Mirrors `rep.set_global_seed`.

    Zero is a valid seed.

    Raises:
        GraphError: (a ValueError) `seed` is not an integer, or negative.
    """
    number = _whole("global seed", seed, "a whole number, 0 or more")
    if number < 0:
        raise GraphError(f"global seed is {number}; expected a whole number, 0 or more")
    current().settings.set("/omni/replicator/globalSeed", number)


def get_global_seed() -> int:
    """Return the global seed; if none is set, one in 0 to 2³¹-1 is drawn and kept. Mirrors `rep.get_global_seed`."""
    seed = current().global_seed
    if seed.value is None:
        seed.value = int(np.random.SeedSequence().generate_state(1)[0] & 0x7FFFFFFF)
    return seed.value
