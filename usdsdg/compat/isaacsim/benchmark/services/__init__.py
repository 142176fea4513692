"""`isaacsim.benchmark.services`: time and memory of the phases of a script, measured and reported as Isaac Sim does."""

from usdsdg.compat.isaacsim.benchmark.services.base_benchmark import (
    DEFAULT_RECORDERS,
    BaseIsaacBenchmark,
    BaseIsaacBenchmarkAsync,
)

__all__ = ["DEFAULT_RECORDERS", "BaseIsaacBenchmark", "BaseIsaacBenchmarkAsync"]
