"""Files and folders that the system does not let a command reach, wherever it comes upon them."""

import errno

from usdsdg.errors import ConfigError

_NAME_ANOTHER = "name another, or mount the disk or share that it is on again"
_REMEDIES = {
    errno.EACCES: "let this user read it and enter the folders that it is in, or name another",
    errno.EPERM: "let this user read or write it, or name another",
    errno.ENAMETOOLONG: "give a shorter one",
    errno.ENOSPC: "free space there, or name another",
    errno.EDQUOT: "free space there, or name another",
    errno.EROFS: "name one that can be written",
    errno.EMFILE: "raise the limit of open files (ulimit -n)",
    errno.ENFILE: "close programs that have many files open",
    errno.EIO: _NAME_ANOTHER,
    errno.ESTALE: _NAME_ANOTHER,
    errno.ENOTCONN: _NAME_ANOTHER,
}


def out_of_reach(error: BaseException) -> ConfigError | None:
    """Return the error of a file or folder that cannot be reached, with a remedy; None for another error."""
    if not isinstance(error, OSError) or error.filename is None or (remedy := _REMEDIES.get(error.errno or 0)) is None:
        return None
    return ConfigError(f"{error.filename}: {error.strerror}; {remedy}")
