"""Run a command of usdsdg in a process that multiprocessing spawns: `python -m tests.programs.spawned ARGUMENTS`."""

import multiprocessing
import sys


def command(arguments: list[str]) -> None:
    """Do what `usdsdg ARGUMENTS` does."""
    from usdsdg.cli.program import main

    sys.argv = ["usdsdg", *arguments]
    main()


if __name__ == "__main__":
    process = multiprocessing.get_context("spawn").Process(target=command, args=(sys.argv[1:],))
    process.start()
    process.join()
    sys.exit(process.exitcode)
