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

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_MIX_1 = np.uint64(0xBF58476D1CE4E5B9)
_MIX_2 = np.uint64(0x94D049BB133111EB)


@lru_cache(maxsize=1 << 17)
def hash_text(text: str) -> int:
    """Return a 64-bit hash of a string that is the same in every process."""
    return int.from_bytes(hashlib.blake2b(text.encode(), digest_size=8).digest(), "little")


def _mixed(state: np.ndarray, part: np.ndarray | np.uint64 | int) -> np.ndarray:
    """Fold `part` into `state`; both uint64, broadcast against each other."""
    with np.errstate(over="ignore"):
        z = state ^ np.asarray(part, dtype=np.uint64)
        z = z + _GOLDEN
        z = (z ^ (z >> np.uint64(30))) * _MIX_1
        z = (z ^ (z >> np.uint64(27))) * _MIX_2
        return z ^ (z >> np.uint64(31))


def _state(seed: int, node: str, execution: int | np.ndarray) -> np.ndarray:
    state = _mixed(np.zeros(1, np.uint64), np.uint64(seed & 0xFFFFFFFFFFFFFFFF))
    state = _mixed(state, np.uint64(hash_text(node)))
    return _mixed(state, np.asarray(execution, np.uint64))


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
    rows = np.array([hash_text(prim) for prim in prims], dtype=np.uint64)
    state = _state(seed, node, execution)
    per_prim = _mixed(state[:, None] if np.ndim(execution) else state, rows)
    columns = np.arange(components, dtype=np.uint64)
    bits = _mixed(per_prim[..., None], columns)
    return (bits >> np.uint64(11)).astype(np.float64) * 2.0**-53


def generator(seed: int, node: str, execution: int, *parts: str) -> np.random.Generator:
    """Return a NumPy generator for one execution of one node, for draws of unknown length (rejection, shuffles)."""
    state = _state(seed, node, execution)
    for part in parts:
        state = _mixed(state, np.uint64(hash_text(part)))
    return np.random.Generator(np.random.Philox(key=int(state[0])))


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
