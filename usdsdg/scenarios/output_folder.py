"""Output folders of scenarios: relative to the working directory, except for URLs and prefixes in a bucket."""

import os
from collections.abc import Mapping
from typing import Any

from usdsdg.stores.addresses import is_url


def below(output_dir: str, name: str) -> str:
    """Return a folder or URL below an output folder."""
    return f"{output_dir.rstrip('/')}/{name}" if is_url(output_dir) else os.path.join(output_dir, name)


def with_absolute_output_dir(arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Return a writer's arguments with an absolute `output_dir`, unless it is a URL or a prefix in a bucket."""
    output_dir = arguments.get("output_dir")
    in_bucket = arguments.get("use_s3", arguments.get("s3_bucket"))
    if not output_dir or not isinstance(output_dir, str) or in_bucket or is_url(output_dir):
        return dict(arguments)
    return {**arguments, "output_dir": os.path.abspath(os.path.expanduser(output_dir))}
