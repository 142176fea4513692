"""Several backends behind one, and the backend that a writer's arguments ask for."""

import os
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from typing import Any

from usdsdg.errors import WriterError
from usdsdg.session.session import current
from usdsdg.stores.addresses import is_url
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.backends.disk import DiskBackend
from usdsdg.writers.backends.store import S3Backend, StoreBackend


class BackendGroup(BaseBackend):
    """Backends that all receive every file; files are read from the first. Mirrors `rep.backends.BackendGroup`."""

    def __init__(self, backends: Sequence[BaseBackend]) -> None:
        self.backends = list(backends)
        if any(isinstance(each, DiskBackend) for each in self.backends):
            for each in self.backends:
                if isinstance(each, StoreBackend):
                    each.keeps_journal = False

    def initialize(self, *args: Any, **kwargs: Any) -> None:
        """Run `__init__`, for a group that came from `get`."""
        self.__init__(*args, **kwargs)

    @property
    def _backends(self) -> list[BaseBackend]:
        """Replicator's name of `backends`, which copies of its writers read."""
        return self.backends

    @property
    def output_dir(self) -> str:
        """The output folder of the first backend that has one."""
        for backend in self.backends:
            if hasattr(backend, "output_dir"):
                return backend.output_dir  # type: ignore[attr-defined]
        raise WriterError("None of the backends of this group writes into a folder.")

    def write_blob(self, path: str, data: bytes) -> None:
        for backend in self.backends:
            backend.write_blob(path, data)

    def read_blob(self, path: str) -> bytes:
        return self.backends[0].read_blob(path)

    def write_chunks(self, path: str, chunks: Iterable[bytes | memoryview]) -> None:
        for backend in self.backends:
            backend.write_chunks(path, chunks)

    def schedule(self, fn: Callable[..., None], *args: Any, **kwargs: Any) -> None:
        for backend in self.backends:
            backend.schedule(fn, *args, **kwargs)

    def schedule_in_turn(self, turn: Hashable, fn: Callable[..., None], *args: Any, **kwargs: Any) -> None:
        for backend in self.backends:
            backend.schedule_in_turn(turn, fn, *args, **kwargs)

    def schedule_after_all(self, fn: Callable[..., None], *args: Any, **kwargs: Any) -> None:
        for backend in self.backends:
            backend.schedule_after_all(fn, *args, **kwargs)

    def is_done_writing(self) -> bool:
        return all(backend.is_done_writing() for backend in self.backends)

    def wait_until_done(self) -> None:
        for backend in self.backends:
            backend.wait_until_done()


class BackendDispatch(BackendGroup):
    """A disk or S3 backend, or both, from the arguments of older writers. Mirrors `rep.BackendDispatch`."""

    def __init__(
        self,
        config: Mapping[str, Any] | None = None,
        output_dir: str | os.PathLike | None = None,
        key_prefix: str | None = None,
        bucket: str | None = None,
        region: str | None = None,
        endpoint_url: str | None = None,
        overwrite: bool = True,
        *,
        use_s3: bool | None = None,
    ) -> None:
        """Write to a folder, to a bucket, or to both.

        config: {"paths": {"out_dir": folder, "s3_bucket": name, "s3_region": ..., "s3_endpoint_url": ...}}, an
            alternative to `output_dir`, `bucket`, `region` and `endpoint_url`; beside "paths" it may have "use_s3".
        output_dir: a folder, or a URL of a bucket with a prefix, as "s3://bucket/runs/7", "gs://..." or "az://...".
        key_prefix: prefix of the keys in the bucket; default, `output_dir`, and then no local files are written.
        region, endpoint_url: of the bucket; see `S3Backend`.
        use_s3: False leaves the bucket out.

        Raises:
            WriterError: neither a folder nor a bucket is given.
            OutputNotWritable, Unsupported: as `DiskBackend` and `S3Backend`.
        """
        known = config or {}
        paths = known.get("paths", {})
        folder, bucket = output_dir or paths.get("out_dir"), bucket or paths.get("s3_bucket")
        region = region or paths.get("s3_region")
        endpoint_url = endpoint_url or paths.get("s3_endpoint_url") or paths.get("s3_endpoint")
        if (known.get("use_s3", True) if use_s3 is None else use_s3) is False:
            bucket = None
        backends: list[BaseBackend] = []
        if folder and (key_prefix or not bucket):
            backends.append(_backend_at(folder, region, endpoint_url, overwrite))
        if bucket:
            if not key_prefix and folder and is_url(folder):
                raise WriterError(f"{folder} has a bucket of its own, but {bucket!r} is given, too; leave one out.")
            prefix = key_prefix or (os.fspath(folder) if folder else None)
            backends.append(S3Backend(bucket, prefix, region, endpoint_url, overwrite))
        if not backends:
            raise WriterError("BackendDispatch has nowhere to write: give output_dir, or bucket and key_prefix.")
        super().__init__(backends)

    # These are called on the class, too, so they are about every backend.
    @staticmethod
    def is_done_writing() -> bool:
        """Return whether every backend has written everything."""
        return current().io_queue.is_done_writing()

    @staticmethod
    def wait_until_done() -> None:
        """Block until every backend has written everything; raises the first failure."""
        current().io_queue.wait_until_done()

    @staticmethod
    def sync_pending_paths() -> None:
        """As `wait_until_done`: writers for older versions of Replicator end with it in `on_final_frame`."""
        current().io_queue.wait_until_done()

    @staticmethod
    def set_max_queue_size(jobs: int) -> None:
        """Set how many jobs of all backends may wait before `schedule` blocks."""
        current().io_queue.set_max_queue_size(jobs)


def _backend_at(place: str | os.PathLike, region: str | None, endpoint_url: str | None, overwrite: bool) -> BaseBackend:
    """Return the backend of a folder or a URL."""
    if isinstance(place, str) and is_url(place) and not place.lower().startswith("file:"):
        return StoreBackend(place, region, endpoint_url, overwrite)
    return DiskBackend(place, overwrite)


def make_backend(
    writer: str,
    output_dir: str | os.PathLike | None,
    backend: BaseBackend | None,
    *,
    bucket: str | None = None,
    region: str | None = None,
    endpoint_url: str | None = None,
) -> BaseBackend:
    """Return the backend of a writer: the one given, one for the folder, or a group of both.

    output_dir: a folder, or a URL of a bucket with a prefix.
    bucket: write there instead of into the folder, with `output_dir` as the key prefix.

    Raises:
        WriterError: nothing is given, or `backend` is not a BaseBackend.
    """
    if backend is not None and not isinstance(backend, BaseBackend):
        raise WriterError(
            f"{writer}: backend must be a BaseBackend, such as backends.get('DiskBackend'); got {backend!r}."
        )
    if not output_dir and not bucket:
        if backend is None:
            raise WriterError(f"{writer} has nowhere to write: give output_dir, or backend.")
        return backend
    folder = BackendDispatch(output_dir=output_dir, bucket=bucket, region=region, endpoint_url=endpoint_url)
    if backend is None:
        return folder
    known = backend.backends if isinstance(backend, BackendGroup) else [backend]
    return BackendGroup([*known, *folder.backends])
