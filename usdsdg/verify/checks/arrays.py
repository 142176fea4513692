"""Arrays that are AOVs as they were rendered: motion vectors."""

from __future__ import annotations

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.seen import Seen
from usdsdg.record import samples


def check(seen: Seen) -> Faults:
    """Compare the checksums of arrays other than depth."""
    for name, (file, values) in seen.arrays.items():
        known = seen.truth.product.checksums.get(name) if seen.truth else None
        if known is None or name.startswith("distance_"):
            continue
        # Two channels were rendered; the others are 0.
        if samples.checksum(np.ascontiguousarray(values[..., :2])) != known or values[..., 2:].any():
            yield Fault(file, seen.name, f"{name} is not as it was rendered")
