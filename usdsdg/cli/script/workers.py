"""Several processes that make the frames of a script."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from usdsdg.cli.script.conditions import Conditions
from usdsdg.errors import BadValue, WorkerFailed, counted

PART = "--part"  # an option of `usdsdg run` that is not listed


class ScriptWorkers:
    """Processes that make a script's frames, once this one has run through it.

    Only a script itself tells how many frames it has, and where they go. So this process runs it first, without
    rendering or writing, which claims its output folders; then each process makes some frames in a row.
    """

    def __init__(
        self,
        script: Path,
        arguments: Sequence[str],
        count: int,
        conditions: Conditions,
        *,
        threads: int | None,
        allow_outside: bool,
        **options: object,
    ) -> None:
        """Let this process count frames from now on.

        count: of processes. threads: of each; None: an equal share. options: others of `usdsdg run`.
        """
        from usdsdg.parallel import available_threads
        from usdsdg.session.session import current

        current().run.counts_only = True
        self._count, self._folder = count, Path.cwd()
        self._command = ["run", "--threads", str(threads or max(1, available_threads() // count))]
        for name, value in {**_options_of(conditions), "--allow-outside": allow_outside, **_named(options)}.items():
            self._command += _given(name, value)
        self._command += [str(script.absolute()), "--", *arguments]

    def make(self) -> None:
        """Make the frames that were counted.

        Raises:
            BadValue: the script has written to no folder and to no store, or has captured nothing.
            WorkerFailed: a process has failed.
            ReachedEnd: with code 1, since the script caught an error in one of them.
        """
        from usdsdg.cli.options.command_context import ReachedEnd
        from usdsdg.session import session
        from usdsdg.session.progress import say
        from usdsdg.workers.dataset import make_claimed, on_this_machine

        run = session.current().run
        folders, frames = run.folders, run.captures
        run.release()
        if not folders or not frames:
            raise BadValue(
                "--workers: the script has captured no frame with a writer that writes to a folder or store, so there "
                "is nothing to be shared out; run it without --workers"
            )
        processes = counted(min(self._count, frames), "process", "processes")
        if not all(each.was_complete for each in folders):
            say(f"{counted(frames, 'frame is', 'frames are')} made by {processes}")
        os.chdir(self._folder)  # which the script may have left
        session.restart()  # its writers are done
        caught: list[str] = []
        make = on_this_machine(self._command, self._count, option=PART, caught=caught)
        make_claimed(folders, frames, self._count, make)
        if caught:
            errors = [line for said in caught for line in said.splitlines() if line.startswith("error: ")]
            print("\n".join(dict.fromkeys(errors)), file=sys.stderr)
            raise ReachedEnd(1)


def caught_code() -> int:
    """Return the exit code of a process that has made its frames, and whose script has caught an error."""
    from usdsdg.workers.local import CAUGHT

    return CAUGHT


def check_part() -> None:
    """Check that the script has come to the frames that this process was to make, before its journal is closed.

    Raises:
        WorkerFailed: it has ended before, unlike in the process that counted them.
    """
    from usdsdg.session.session import current

    run = current().run
    if not run.is_over:
        raise WorkerFailed(
            f"the script ended after {counted(run.captures, 'frame')} here, and captured more of them where they were "
            "counted, so frames of this part are missing. It may end by what frames show, by the time, or by an error "
            "that it catches: run it without --workers"
        )


def _options_of(conditions: Conditions) -> dict[str, object]:
    return {
        "--stage": conditions.stage,
        "--new-stage": conditions.new_stage,
        "--frames": conditions.frames,
        "--replicator": conditions.replicator,
        "--map": list(conditions.maps),
        "--missing-assets": conditions.missing_assets,
        "--lenient": conditions.lenient,
    }


def _named(options: Mapping[str, object]) -> dict[str, object]:
    return {f"--{name.replace('_', '-')}": value for name, value in options.items()}


def _given(name: str, value: object) -> list[str]:
    """Return what stands on a command line for an option with a value."""
    if isinstance(value, bool):
        return [name] if value else []
    values = value if isinstance(value, list) else [] if value is None else [value]
    return [part for each in values for part in (name, str(each))]
