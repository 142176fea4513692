"""Write every format with threads and without: `python -m tests.soak writing_threads` compares all bytes."""

import argparse
import tempfile
from pathlib import Path

from tests.capture.test_writing_beside_rendering import bytes_of
from tests.verify import datasets
from usdsdg.session.session import current
from usdsdg.writers.backends.io_queue import IoQueue


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=200)
    parser.add_argument("--threads", type=int, nargs="+", default=(1, 4, 8))
    options = parser.parse_args()
    expected = _written(0, options.frames)
    wrong = 0
    for threads in options.threads:
        found = _written(threads, options.frames)
        names = sorted({*found, *expected})
        differ = [name for name in names if found.get(name) != expected.get(name)]
        wrong += len(differ)
        print(f"{threads} threads: {len(names)} files, {len(differ)} with other bytes {differ[:5]}", flush=True)
    return int(wrong > 0)


def _written(threads: int, frames: int) -> dict[str, bytes]:
    vars(current())["io_queue"] = IoQueue(threads=threads, max_bytes=1 << 24)
    with tempfile.TemporaryDirectory() as folder:
        return bytes_of(datasets.make(Path(folder), frames=frames))
