"""What an error of obstore means: whether asking again may help, and what a person can do."""

from __future__ import annotations

import re
from typing import NamedTuple

from usdsdg.stores.addresses import Address

_STATUS = re.compile(r"status code: (\d{3})")
_CODE = re.compile(r"<Code>([^<]*)</Code>")
_NO_ANSWER = re.compile(
    r"error sending request|error decoding response|connection|timed? ?out|HTTP error", re.IGNORECASE
)
_NO_ROLE = re.compile(
    r"/latest/(api/token|meta-data)|169\.254\.169\.254|metadata\.google\.internal|/metadata/(identity|instance)"
)

_SIGN_IN = {
    "s3": "set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY (AWS_SKIP_SIGNATURE=true for a public bucket), "
    "or run `aws configure`",
    "gs": "set GOOGLE_APPLICATION_CREDENTIALS to the key file of a service account, "
    "or run `gcloud auth application-default login`",
    "az": "set AZURE_STORAGE_ACCOUNT_NAME, and AZURE_STORAGE_ACCOUNT_KEY or AZURE_STORAGE_SAS_TOKEN",
}
_NEEDS = {
    "s3": "they need s3:ListBucket on the bucket, s3:GetObject and s3:PutObject on its objects",
    "gs": "they need the role Storage Object User on the bucket",
    "az": "they need the role Storage Blob Data Contributor on the container",
}
_WRONG_KEYS = ("InvalidAccessKeyId", "SignatureDoesNotMatch", "InvalidToken", "ExpiredToken", "AuthenticationFailed")
_UNDECIDED = ("ConditionalRequestConflict", "OperationAborted")


class Failure(NamedTuple):
    """What an error means."""

    reason: str  # with what to do about it
    may_pass: bool  # asking again may help
    is_missing: bool = False  # there is no such file
    is_denied: bool = False  # with credentials that are right
    is_unsure: bool = False  # the request may have been carried out all the same
    has_lost: bool = False  # a condition of a put was not met


def failure_of(error: Exception, address: Address) -> Failure:
    """Return what an error of obstore means."""
    kind = type(error).__name__
    text = " ".join(str(error).split("Debug source")[0].split())
    status = int(found[1]) if (found := _STATUS.search(text)) else 0
    code = found[1] if (found := _CODE.search(text)) else ""
    if code in ("NoSuchBucket", "ContainerNotFound") or "bucket does not exist" in text.lower():
        return Failure("there is no such bucket; make it, or name another one", may_pass=False)
    if kind in ("AlreadyExistsError", "PreconditionError"):
        # Amazon says with a 409 that somebody else writes at this moment, not who was first.
        return Failure(f"others write it at the same time ({code or kind})", code in _UNDECIDED, has_lost=True)
    if _NO_ROLE.search(text) or "MissingCredential" in text or code == "MissingAuthenticationToken":
        return Failure(f"there are no credentials for it; {_SIGN_IN.get(address.kind, 'sign in')}", may_pass=False)
    if code == "NoSuchUpload":
        # Of an upload in parts the last answer was lost, and obstore asked for it again: the whole is sent once more.
        return Failure("an upload in parts has ended", may_pass=True, is_unsure=True)
    if isinstance(error, FileNotFoundError) or kind == "NotFoundError" or status == 404:
        return Failure("there is no such file, or no such bucket", may_pass=False, is_missing=True)
    if code in _WRONG_KEYS or kind == "UnauthenticatedError" or status == 401:
        signed = (
            f"the credentials are wrong or have expired ({code or status}); {_SIGN_IN.get(address.kind, 'sign in')}"
        )
        return Failure(signed, may_pass=False)
    if kind == "PermissionDeniedError" or status == 403:
        denied = f"the credentials do not allow it ({code or status}); {_NEEDS.get(address.kind, 'ask its owner')}"
        return Failure(denied, may_pass=False, is_denied=True)
    if "redirect" in text or status in (301, 307):
        return Failure(
            "it is in another region or behind another address; set AWS_REGION, or the region", may_pass=False
        )
    if status >= 500 or status in (408, 429):
        is_passing = status != 501
        return Failure(f"the server answers {status} {code}".rstrip(), may_pass=is_passing, is_unsure=is_passing)
    if not status and _NO_ANSWER.search(text):
        return Failure("the server does not answer; look at its address, region and the network", True, is_unsure=True)
    return Failure(text[:300], may_pass=False)
