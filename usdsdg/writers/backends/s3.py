"""Objects in a bucket of S3, or of a server that speaks its protocol (MinIO, R2, B2, Ceph). Needs the extra `s3`."""

from __future__ import annotations

import itertools
import mimetypes
from typing import Any, NoReturn

from usdsdg.errors import OutputNotWritable, Unsupported, WriterError, warn_once
from usdsdg.writers.backends.backend import BaseBackend

# Requests that a network fault or a busy server ends are tried this often.
ATTEMPTS = 5


def connect(region: str | None, endpoint_url: str | None) -> Any:
    """A boto3 client, with credentials from wherever boto3 looks: the environment, ~/.aws/credentials, a role.

    `S3Backend` calls nothing of it but `put_object`, `get_object` and `list_objects_v2`; tests and programs with a
    client of their own replace this function.

    Raises:
        Unsupported: boto3 is not installed.
    """
    try:
        import boto3
        from botocore.config import Config
    except ImportError as error:
        raise Unsupported(f"S3 needs boto3, which is not installed ({error}): pip install 'usdsdg[s3]'.") from error
    options: dict[str, Any] = {"retries": {"mode": "standard", "max_attempts": ATTEMPTS}}
    if endpoint_url:
        # Buckets are no subdomains of most other servers, and many know nothing of S3's newer checksums.
        options["s3"] = {"addressing_style": "path"}
        options["request_checksum_calculation"] = options["response_checksum_validation"] = "when_required"
    # A session of its own: boto3's shared one keeps the credentials that it began with.
    return boto3.Session().client("s3", region_name=region, endpoint_url=endpoint_url, config=Config(**options))


class S3Backend(BaseBackend):
    """Objects in a bucket. Mirrors `rep.backends.S3Backend`."""

    def __init__(
        self,
        bucket: str,
        key_prefix: str | None,
        region: str | None = None,
        endpoint_url: str | None = None,
        overwrite: bool = False,
    ) -> None:
        """Look at the bucket; warns where there are objects below `key_prefix` already.

        bucket: its name; it must exist.
        key_prefix: what keys begin with, as a folder: "runs/7" gives "runs/7/rgb_0000.png". None: nothing.
        region: such as "eu-central-1"; None: the one that boto3 is configured with.
        endpoint_url: of a server that is not Amazon's, such as "http://localhost:9000".
        overwrite: False puts the objects below another prefix than those that exist, with _0001 (and so on) appended.

        Raises:
            Unsupported: boto3 is not installed.
            OutputNotWritable: the bucket does not exist, or cannot be reached with these credentials.
        """
        self._bucket = bucket
        self._endpoint_url = endpoint_url
        self._client = connect(region, endpoint_url)
        prefix = str(key_prefix or "").strip("/")
        self._prefix = prefix if overwrite or not prefix else self._free_prefix(prefix)
        if self._has_objects(self._prefix):
            warn_once(
                f"{self.output_dir} is not empty: objects with the same keys are replaced, the others stay. "
                "Give another key_prefix to keep runs apart."
            )

    @property
    def output_dir(self) -> str:
        """Where the objects go: "s3://bucket/prefix"."""
        if "_prefix" not in self.__dict__:
            raise WriterError("This S3Backend has no bucket yet: call initialize(bucket=..., key_prefix=...) first.")
        return f"s3://{self._bucket}/{self._prefix}".rstrip("/")

    def resolve_path(self, path: str) -> str:
        """The URL of an object of this backend."""
        return f"{self.output_dir}/{path}"

    def write_blob(self, path: str, data: bytes) -> None:
        """Store `data` in one request: the object appears wholly or not at all.

        Raises:
            OutputNotWritable: the server refused it, or could not be reached.
        """
        kind = mimetypes.guess_type(path)[0] or "application/octet-stream"
        try:
            self._client.put_object(Bucket=self._bucket, Key=self._key(path), Body=data, ContentType=kind)
        except Exception as error:  # noqa: BLE001 - botocore's errors share no class; others are raised again
            self._explain(error, self.resolve_path(path))

    def read_blob(self, path: str) -> bytes:
        """What was stored under `path`.

        Raises:
            FileNotFoundError: nothing was.
            OutputNotWritable: the server could not be reached or refused to tell.
        """
        try:
            return self._client.get_object(Bucket=self._bucket, Key=self._key(path))["Body"].read()
        except Exception as error:
            if _code(error) in ("NoSuchKey", "404"):
                raise FileNotFoundError(self.resolve_path(path)) from error
            self._explain(error, self.resolve_path(path))

    def _key(self, path: str) -> str:
        return f"{self._prefix}/{path}" if self._prefix else path

    def _free_prefix(self, prefix: str) -> str:
        numbered = (f"{prefix}_{number:04d}" for number in itertools.count(1))
        return next(each for each in itertools.chain([prefix], numbered) if not self._has_objects(each))

    def _has_objects(self, prefix: str) -> bool:
        below = f"{prefix}/" if prefix else ""
        try:
            return bool(self._client.list_objects_v2(Bucket=self._bucket, Prefix=below, MaxKeys=1).get("Contents"))
        except Exception as error:  # noqa: BLE001 - as above
            self._explain(error, f"s3://{self._bucket}/{below}")

    def _explain(self, error: Exception, where: str) -> NoReturn:
        """Raise an error of botocore's as ours, with what to do; any other as it is."""
        code = _code(error)
        if code is None:
            raise error
        server = self._endpoint_url or "Amazon S3"
        raise OutputNotWritable(
            f"{where} cannot be written: {_REASONS.get(code, str(error))} (server: {server})."
        ) from error


_NO_KEYS = (
    "there are no credentials for it; set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, or write ~/.aws/credentials"
)
_MAY_NOT = "the credentials do not allow it; they need s3:ListBucket on the bucket and s3:PutObject on its objects"
_NO_BUCKET = "there is no such bucket; make it, or name another one"
_NO_SERVER = "the server does not answer; look at endpoint_url, region and the network"
# Codes of the server, and names of botocore's own errors.
_REASONS = {
    **dict.fromkeys(["NoCredentialsError", "PartialCredentialsError"], _NO_KEYS),
    **dict.fromkeys(["AccessDenied", "403", "InvalidAccessKeyId", "SignatureDoesNotMatch", "ExpiredToken"], _MAY_NOT),
    "NoSuchBucket": _NO_BUCKET,
    **dict.fromkeys(["EndpointConnectionError", "ConnectTimeoutError", "ConnectionClosedError"], _NO_SERVER),
}


def _code(error: Exception) -> str | None:
    """The server's code of an error, or the name of botocore's own; None for all others."""
    response = getattr(error, "response", None)
    if isinstance(response, dict):
        return str(response.get("Error", {}).get("Code", "?"))
    # By name: botocore is there only where the extra is.
    return type(error).__name__ if type(error).__module__.startswith("botocore.") else None
