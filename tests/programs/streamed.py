"""Print what processes of a stream show of each frame: `python -m tests.programs.streamed COUNT SCRIPT OUTPUT`.

With 0 processes the script runs in a thread of this one, as with DataLoader's num_workers=0; else in so many forks, as
its workers are, each of which makes every COUNT-th frame.
"""

import hashlib
import json
import multiprocessing
import sys
from typing import Any

ANNOTATORS = ("rgb", "bounding_box_2d_tight", "semantic_segmentation")


def shown(arguments: tuple[str, str], part: tuple[int, int]) -> dict[str, str]:
    """Return hashes of what a part of the frames shows, by frame and render product."""
    from usdsdg import stream

    found = {}
    for sample in stream.frames(arguments[0], ANNOTATORS, arguments=arguments[1:], part=part):
        digest = hashlib.sha256()
        for name, array in sorted(sample.arrays.items()):
            digest.update(name.encode() + str(array.shape).encode() + array.tobytes())
        found[f"{sample.frame} {sample.render_product}"] = digest.hexdigest()
    return found


def in_fork(arguments: tuple[str, str], part: tuple[int, int], results: Any) -> None:
    """Put what `shown` returns into a queue; None if it failed."""
    from usdsdg.session import session

    session.restart()
    try:
        results.put(shown(arguments, part))
    except BaseException:
        results.put(None)
        raise


def main() -> int:
    count, *arguments = int(sys.argv[1]), *sys.argv[2:]
    found: dict[str, str] = {}
    if count == 0:
        found = shown((arguments[0], arguments[1]), (0, 1))
    else:
        context = multiprocessing.get_context("fork")
        results = context.Queue()
        forks = [
            context.Process(target=in_fork, args=(tuple(arguments), (number, count), results))
            for number in range(count)
        ]
        for fork in forks:
            fork.start()
        for part in [results.get(timeout=180) for _ in forks]:
            if part is None:
                return 1
            found |= part
        for fork in forks:
            fork.join()
    print("SHOWN " + json.dumps(found, sort_keys=True))
    return 0


if __name__ == "__main__":
    sys.exit(main())
