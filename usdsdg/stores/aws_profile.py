"""What `aws configure` wrote: keys, region and endpoint of a profile, which obstore does not read."""

from __future__ import annotations

import configparser
import os
from collections.abc import Mapping
from pathlib import Path

from usdsdg.errors import StoreError
from usdsdg.operating_system import home_folder

# Where the environment has one of these, it says whose credentials are used.
_OTHER_SOURCES = (
    "AWS_ACCESS_KEY_ID",
    "AWS_WEB_IDENTITY_TOKEN_FILE",
    "AWS_CONTAINER_CREDENTIALS_RELATIVE_URI",
    "AWS_CONTAINER_CREDENTIALS_FULL_URI",
    "AWS_SKIP_SIGNATURE",
)
_KEYS = {
    "aws_access_key_id": "access_key_id",
    "aws_secret_access_key": "secret_access_key",
    "aws_session_token": "session_token",
}
_PLACES = {"region": ("region", ("AWS_REGION", "AWS_DEFAULT_REGION")), "endpoint_url": ("endpoint", ())}


def aws_profile() -> dict[str, str]:
    """Return the options of obstore's S3Store that the profile AWS_PROFILE ("default") has and the environment lacks.

    Raises:
        StoreError: AWS_PROFILE names a profile that is not there, a file is broken, or the profile has no keys but asks
            for a log-in or a role.
    """
    name = os.environ.get("AWS_PROFILE", "default")
    keys = _section("AWS_SHARED_CREDENTIALS_FILE", "credentials", name)
    config = _section("AWS_CONFIG_FILE", "config", name if name == "default" else f"profile {name}")
    has_source = any(os.environ.get(each) for each in _OTHER_SOURCES)
    if "AWS_PROFILE" in os.environ and not keys and not config and not has_source:
        raise StoreError(f"AWS_PROFILE is {name!r}, but ~/.aws has no such profile; make it with `aws configure`.")
    both = {**config, **keys}
    options = {} if has_source else {ours: both[theirs] for theirs, ours in _KEYS.items() if both.get(theirs)}
    if not has_source and not options and any(each.startswith(("sso_", "role_arn", "credential_")) for each in both):
        raise StoreError(
            f"The AWS profile {name!r} gets its keys from a log-in, a role or a program; put them into the "
            'environment: eval "$(aws configure export-credentials --format env)"'
        )
    for theirs, (ours, variables) in _PLACES.items():
        if both.get(theirs) and not any(os.environ.get(each) for each in variables):
            options[ours] = both[theirs]
    for variable in ("AWS_ENDPOINT_URL_S3", "AWS_ENDPOINT_URL", "AWS_ENDPOINT"):
        if os.environ.get(variable):
            options["endpoint"] = os.environ[variable]
            break
    return options


def _section(variable: str, name: str, section: str) -> Mapping[str, str]:
    """Return a section of a file of ~/.aws; nothing if there is none."""
    if given := os.environ.get(variable):
        file = Path(os.path.expanduser(given))
    elif (home := home_folder()) is not None:
        file = home / ".aws" / name
    else:
        return {}
    parser = configparser.RawConfigParser()
    try:
        parser.read(file, encoding="utf-8")
    except (configparser.Error, UnicodeDecodeError) as error:
        raise StoreError(f"{file} cannot be read: {' '.join(str(error).split())}") from error
    return dict(parser[section]) if parser.has_section(section) else {}
