"""Where the files of a job's writers go while its frames are handed over: to none of the folders that it names."""

from collections.abc import Iterator
from contextlib import contextmanager

from usdsdg.session.session import current
from usdsdg.stores.temporary import TemporaryFolder
from usdsdg.writers.journal.run import get_run


@contextmanager
def files_aside(*, keeps_folders: bool) -> Iterator[None]:
    """Let what the writers and backends of the session write end in a temporary folder.

    A dataset that is where a job would write stays as it is, whatever the job does to its writers.

    keeps_folders: the folders of writers are made nevertheless, for files that a script writes there itself.

    Raises:
        OutputNotWritable: there is no folder for temporary files.
    """
    with TemporaryFolder("stream") as scratch:
        get_run().set_aside(scratch.resolve(), keeps_folders=keeps_folders)
        try:
            yield
        finally:
            current().io_queue.wait_until_done()
