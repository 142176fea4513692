"""Compare worlds with frames over random graphs: `python -m tests.soak worlds` shall find no difference in 300."""

import argparse
from collections import Counter

from tests.worlds import scenes
from tests.worlds.random_graphs import RandomGraph
from usdsdg.errors import Unsupported

WORLDS, STEPS = 3, 2


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--graphs", type=int, default=300)
    parser.add_argument("--first", type=int, default=0, help="seed of the first graph, to go on after another run")
    options = parser.parse_args()
    found: Counter[str] = Counter()
    for seed in range(options.first, options.first + options.graphs):
        graph = RandomGraph(seed)
        try:
            scenes.compared(graph, WORLDS, STEPS)
            found["equal"] += 1
        except Unsupported as error:
            found["refused"] += 1
            print(f"seed {seed}: {error}", flush=True)
        except AssertionError as error:
            found["different"] += 1
            print(f"seed {seed}, {', '.join(graph.nodes)}: {error}", flush=True)
    print(f"{options.graphs} graphs: {dict(found)}")
    return int(found["different"] > 0)
