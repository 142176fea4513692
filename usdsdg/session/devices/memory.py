"""An error with a remedy where the memory of a device is used up."""

import re
from collections.abc import Iterator
from contextlib import contextmanager

from usdsdg.errors import OutOfDeviceMemory

# As Warp says it, on CPUs too.
_FAILURE = re.compile(r"Failed to allocate (\d+) bytes on device '([^']+)'")
GB = 1e9


@contextmanager
def device_memory() -> Iterator[None]:
    """Turn Warp's failure to allocate into an `OutOfDeviceMemory`.

    Raises:
        OutOfDeviceMemory: what the body renders does not fit; says how much was asked for and is there.
    """
    try:
        yield
    except RuntimeError as error:
        found = _FAILURE.search(str(error))
        if found is None:
            raise
        raise OutOfDeviceMemory(_message(int(found[1]), found[2])) from error


def _message(size: int, device: str) -> str:
    there = ""
    if device != "cpu":
        import warp as wp

        used = wp.get_device(device)
        there = f", {used.free_memory / GB:.2f} GB of {used.total_memory / GB:.2f} GB free,"
    remedies = "fewer worlds (--worlds) or cameras at a time, or smaller images"
    if device != "cpu":
        remedies += ", or on the CPU (--device cpu)"
    return f"the memory of {device}{there} does not suffice for {size / GB:.2f} GB more. Render {remedies}."
