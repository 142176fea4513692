"""Color images: byte for byte those that were rendered, or block by block where the format loses detail."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.seen import Color, Seen
from usdsdg.record import samples
from usdsdg.record.frame_record import OPAQUE
from usdsdg.verify.checks.compare import of_pixels, shapes_agree

# Levels by which the mean of a block of a JPEG may be off.
_LOSS = 12
# Steps of a normal in an 8-bit image, and of the record.
_NORMAL = 2 / 255 + 1 / 127


def check(seen: Seen, frames: Mapping[int, str]) -> Faults:
    """frames: frame by checksum of its color image, to name what an image shows instead."""
    if seen.truth is None:
        yield from _sizes(seen)
        return
    product = seen.truth.product
    for color in seen.colors:
        yield from shapes_agree(seen, color.file, color.image.shape, product.shape)
        if color.image.shape[:2] == product.shape:
            yield from _compared(seen, color, frames)
    for normals in seen.normals:
        yield from shapes_agree(seen, normals.file, normals.image.shape, product.shape)
        exact = product.checksums.get("normal_image") if normals.exact else None
        if exact is not None and samples.checksum(np.ascontiguousarray(normals.image[..., :3])) == exact:
            continue
        if product.normals is not None and normals.image.shape[:2] == product.shape:
            recorded = product.normals / 127.0
            found = samples.grid(normals.image[..., :3]) / 255.0 * 2 - 1
            wrong = np.abs(found - recorded).max(axis=2) > (_NORMAL if normals.exact else 0.25)
            if wrong.mean() > (0.0 if normals.exact else 0.2):
                yield Fault(normals.file, seen.name, f"normals are not the recorded ones in {of_pixels(wrong)}")
            elif exact is not None:
                yield Fault(normals.file, seen.name, "normals are not the rendered ones, byte for byte")


def _sizes(seen: Seen) -> Faults:
    """Without a record: all pictures of an image have one size, that of most of them."""
    shapes = [
        *((each.file, each.image.shape) for each in (*seen.colors, *seen.normals)),
        *((each.file, each.keys.shape) for each in seen.ids),
        *((each.file, each.values.shape) for each in seen.depths),
    ]
    if shapes:
        ((size, _),) = Counter((rows, columns) for _, (rows, columns, *_) in shapes).most_common(1)
        for file, shape in shapes:
            yield from shapes_agree(seen, file, shape, size)


def _compared(seen: Seen, color: Color, frames: Mapping[int, str]) -> Faults:
    assert seen.truth is not None
    product, image = seen.truth.product, color.image
    if image.ndim != 3 or image.dtype != np.uint8:
        yield Fault(color.file, seen.name, "is no color image", "8-bit RGB or RGBA", f"{image.dtype} {image.shape}")
        return
    if color.exact and "LdrColor" in product.checksums:
        if image.shape[2] == 3 and OPAQUE in product.checksums:
            found, expected = samples.checksum(np.ascontiguousarray(image)), product.checksums[OPAQUE]
        else:
            found, expected = samples.checksum(whole(image)), product.checksums["LdrColor"]
        if found != expected:
            yield Fault(color.file, seen.name, "is not the rendered image", "", frames.get(found, ""))
    elif product.thumbnail is not None:
        off = np.abs(samples.block_means(image).astype(int) - product.thumbnail).max(axis=2)
        if (off > _LOSS).any():
            yield Fault(
                color.file,
                seen.name,
                f"is not the rendered image in {of_pixels(off > _LOSS).replace('pixels', 'blocks')}",
            )


def whole(image: np.ndarray) -> np.ndarray:
    """Return an image with four channels."""
    if image.shape[2] == 4:
        return image
    return np.concatenate([image[..., :3], np.full((*image.shape[:2], 1), 255, np.uint8)], axis=2)
