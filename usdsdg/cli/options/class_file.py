"""Whether `--semantic-classes` names a file, or the classes themselves."""

import errno
import os
from pathlib import Path

SUFFIXES = (".json", ".yaml", ".yml", ".txt")


def class_file(given: str) -> Path | None:
    """Return the class file or the dataset's folder that the option names; None where it lists names of classes.

    What does not exist is a file if it ends as one, or has a slash and no comma.
    """
    path = Path(given)
    try:
        if path.exists():
            return path
    except OSError as error:
        # Names of classes may be longer than a path; what is in a folder that this user may not enter is a file.
        return None if error.errno == errno.ENAMETOOLONG else path
    is_path = path.suffix.lower() in SUFFIXES or (os.sep in given and "," not in given)
    return path if is_path else None
