"""NumPy generators seeded with the global seed. Mirrors `rep.rng`."""

from typing import Any

import numpy as np

from usdsdg.arguments.parameters import name_parameters
from usdsdg.graph.sampling import get_global_seed, own_seed, set_global_seed
from usdsdg.session.session import current

__all__ = ["ReplicatorRNG", "generator_of", "get_global_seed", "reset_all", "set_global_seed"]


class ReplicatorRNG:
    """Random numbers for scripts: `ReplicatorRNG(seed=42).generator.uniform(size=(5, 3))`.

    Without a seed (or with a negative one) the global seed is used. All generators are reset when the global seed
    changes and when the orchestrator starts (`reset_all`), so that a second run repeats the first.
    The streams are those of Replicator: the same seed gives the same numbers.
    """

    def __init__(self, seed: int | None = None, node: Any = None) -> None:
        """Seed a generator for `node`, the graph node that draws (or its name); each node has its own stream."""
        self._node: Any = None
        self._node_id = 0
        self.initialize(seed, node)
        current().random_generators.add(self)

    def initialize(self, seed: int | None, node: Any = None, node_id: int | None = None) -> None:
        """Reset with another seed, and for another node if one is given; `node_id` distinguishes nodes.

        Raises:
            GraphError: (a ValueError) `seed` is not an integer.
        """
        own_seed(seed)
        self._seed = None if seed is None else int(seed)
        self._node = self._node if node is None else node
        self._node_id = self._node_id if node_id is None else int(node_id)
        self.reset()

    def reset(self) -> None:
        """Restart the stream."""
        own = self._seed is not None and self._seed >= 0
        entropy: Any = self._seed if own else get_global_seed()
        if self._node is not None:
            entropy = (entropy, 0 if own else self._node_id)
        self._generator = np.random.default_rng(np.random.SeedSequence(entropy))

    @property
    def generator(self) -> np.random.Generator:
        """The generator to draw from; `reset` replaces it, so do not keep a reference."""
        return self._generator

    @property
    def seed(self) -> int | None:
        """The seed; setting it resets the generator."""
        return self._seed

    @seed.setter
    def seed(self, value: int | None) -> None:
        self.initialize(value)

    def __repr__(self) -> str:
        return f"ReplicatorRNG(seed={self._seed})"


def reset_all() -> None:
    """Reset all generators, as when a stopped orchestrator starts."""
    for rng in list(current().random_generators):
        rng.reset()


def generator_of(rng: ReplicatorRNG | np.random.Generator) -> np.random.Generator:
    """Return the NumPy generator of an `rng` argument.

    Raises:
        TypeError: `rng` is neither a ReplicatorRNG nor a NumPy Generator.
    """
    generator = rng.generator if isinstance(rng, ReplicatorRNG) else rng
    if not isinstance(generator, np.random.Generator):
        raise TypeError(f"rng is {rng!r}; expected rep.rng.ReplicatorRNG() or numpy.random.default_rng()")
    return generator


name_parameters(globals(), without_turns=None)
