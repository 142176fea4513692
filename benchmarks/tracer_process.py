"""The child of `path_tracers.TracerProcess`: make a tracer, then render the requested images."""

from __future__ import annotations

import importlib
import os
import pickle
import sys
import time


def main() -> None:
    # What tracers print must not mix with the answers.
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    module, name = sys.argv[1].split(":")
    scene, options = pickle.load(sys.stdin.buffer)
    tracer = getattr(importlib.import_module(module), name)(scene, **options)
    answer(answers, tracer.name)
    while True:
        try:
            question = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        cpu, wall = time.process_time(), time.perf_counter()
        image = tracer.render(*question)
        answer(answers, (image, time.process_time() - cpu, time.perf_counter() - wall))


def answer(answers, what: object) -> None:
    pickle.dump(what, answers)
    answers.flush()


if __name__ == "__main__":
    main()
