"""Objects in an S3 bucket, or on a server with the same protocol (MinIO, R2, B2, Ceph). Needs the extra `s3`.

It uses boto3, which finds credentials in all the usual places; 60 objects of 0.5 MB take 1.25 s against 0.8 s with
obstore, but on the I/O queue, several at a time.
"""

import itertools
import mimetypes
from typing import Any, NoReturn

from usdsdg.errors import OutputNotWritable, Unsupported, WriterError, warn_once
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.backends.blob_key import checked_key

# Attempts per request, for network faults and busy servers.
ATTEMPTS = 5


def connect(region: str | None, endpoint_url: str | None) -> Any:
    """Create a boto3 client, with credentials from the environment, ~/.aws/credentials or a role.

    `S3Backend` only calls its `put_object`, `get_object` and `list_objects_v2`; tests and programs with a client of
    their own replace this function.

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
        # Most other servers have no bucket subdomains, and many do not support S3's newer checksums.
        options["s3"] = {"addressing_style": "path"}
        options["request_checksum_calculation"] = options["response_checksum_validation"] = "when_required"
    # A new session, since boto3's shared one keeps its first credentials.
    return boto3.Session().client("s3", region_name=region, endpoint_url=endpoint_url, config=Config(**options))


class S3Backend(BaseBackend):
    """A backend that writes objects into a bucket. Mirrors `rep.backends.S3Backend`."""

    def __init__(
        self,
        bucket: str,
        key_prefix: str | None,
        region: str | None = None,
        endpoint_url: str | None = None,
        overwrite: bool = False,
    ) -> None:
        """Connect to the bucket; warn if there are objects below `key_prefix`.

        bucket: name of an existing bucket.
        key_prefix: prefix of the keys, as a folder: "runs/7" gives "runs/7/rgb_0000.png". None: no prefix.
        region: such as "eu-central-1"; None: the one that boto3 is configured with.
        endpoint_url: URL of a server other than Amazon's, such as "http://localhost:9000".
        overwrite: False writes below a new prefix next to an existing one, with _0001 (and so on) appended.

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
        """The URL of the prefix: "s3://bucket/prefix"."""
        if "_prefix" not in self.__dict__:
            raise WriterError("This S3Backend has no bucket yet: call initialize(bucket=..., key_prefix=...) first.")
        return f"s3://{self._bucket}/{self._prefix}".rstrip("/")

    def resolve_path(self, path: str) -> str:
        """Return the URL of an object of this backend.

        Raises:
            WriterError: `path` is not below the prefix, as one with `..`.
        """
        return f"{self.output_dir}/{checked_key(path, self.output_dir)}"

    def write_blob(self, path: str, data: bytes) -> None:
        """Store `data` in one request, so that the object is complete or absent.

        Raises:
            WriterError: as `resolve_path`.
            OutputNotWritable: the server refused it, or could not be reached.
        """
        key, kind = self._key(path), mimetypes.guess_type(path)[0] or "application/octet-stream"
        try:
            self._client.put_object(Bucket=self._bucket, Key=key, Body=data, ContentType=kind)
        except Exception as error:  # noqa: BLE001 - botocore's errors have no common class; others are raised again
            self._explain(error, self.resolve_path(path))

    def read_blob(self, path: str) -> bytes:
        """Return what was stored under `path`.

        Raises:
            FileNotFoundError: there is no such object.
            OutputNotWritable: the server could not be reached, or denied access.
        """
        key = self._key(path)
        try:
            return self._client.get_object(Bucket=self._bucket, Key=key)["Body"].read()
        except Exception as error:
            if _code(error) in ("NoSuchKey", "404"):
                raise FileNotFoundError(self.resolve_path(path)) from error
            self._explain(error, self.resolve_path(path))

    def _key(self, path: str) -> str:
        key = checked_key(path, self.output_dir)
        return f"{self._prefix}/{key}" if self._prefix else key

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
        """Raise an OutputNotWritable with a remedy for an error of botocore; raise any other as it is."""
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
_DENIED = "the credentials do not allow it; they need s3:ListBucket on the bucket and s3:PutObject on its objects"
_NO_BUCKET = "there is no such bucket; make it, or name another one"
_NO_SERVER = "the server does not answer; look at endpoint_url, region and the network"
# By error code of the server, or class name of botocore's error.
_REASONS = {
    **dict.fromkeys(["NoCredentialsError", "PartialCredentialsError"], _NO_KEYS),
    **dict.fromkeys(["AccessDenied", "403", "InvalidAccessKeyId", "SignatureDoesNotMatch", "ExpiredToken"], _DENIED),
    "NoSuchBucket": _NO_BUCKET,
    **dict.fromkeys(["EndpointConnectionError", "ConnectTimeoutError", "ConnectionClosedError"], _NO_SERVER),
}


def _code(error: Exception) -> str | None:
    """Return the server's error code, or the class name of botocore's error; None for all others."""
    response = getattr(error, "response", None)
    if isinstance(response, dict):
        return str(response.get("Error", {}).get("Code", "?"))
    # By name, since botocore is only installed with the extra.
    return type(error).__name__ if type(error).__module__.startswith("botocore.") else None
