"""Output folders of scenarios: relative to the working directory, except for prefixes in an S3 bucket."""

import os
from collections.abc import Mapping
from typing import Any


def with_absolute_output_dir(arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Return a writer's arguments with an absolute `output_dir`, unless it is a prefix in a bucket."""
    output_dir = arguments.get("output_dir")
    in_bucket = arguments.get("use_s3", arguments.get("s3_bucket"))
    if not output_dir or not isinstance(output_dir, str) or in_bucket:
        return dict(arguments)
    return {**arguments, "output_dir": os.path.abspath(os.path.expanduser(output_dir))}
