"""Augmentations that are Warp kernels: `data_in` to `data_out`, one thread per pixel."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from usdsdg.annotators.augmentations.signatures import defaults_of_kernel
from usdsdg.errors import AugmentationError, warn_once
from usdsdg.warp_start import quiet_warp


def launch(
    kernel: Any, data: np.ndarray, shapes: Sequence[tuple[int, ...]], kwargs: Mapping[str, Any], device: str | None
) -> np.ndarray:
    """Launch `kernel` on `data` with one thread per element of its first two axes, and return `data_out`.

    shapes: what the result may have; it gets the first with as many axes as the kernel declares. Elements that the
        kernel does not write are 0.
    device: "cpu" or "cuda[:n]"; an unavailable device is replaced by the CPU.

    Raises:
        AugmentationError: `data` or `shapes` do not match the arrays that the kernel declares.
    """
    import warp as wp

    declared = {argument.label: argument.type for argument in kernel.adj.args}
    for name in ("data_in", "data_out"):
        if not hasattr(declared.get(name), "ndim"):
            raise AugmentationError(
                f"Kernel {kernel.key} has no array {name}; an augmentation needs data_in and data_out."
            )
    shape = next((each for each in shapes if len(each) == declared["data_out"].ndim), shapes[0])
    for name, of in (("data_in", data.shape), ("data_out", shape)):
        if declared[name].ndim != len(of):
            raise AugmentationError(
                f"Kernel {kernel.key} declares {name} with {declared[name].ndim} axes, and it would be of shape {of}. "
                "data_out_shape says what shape data_out has."
            )
    where = device_or_cpu(device)
    source = wp.array(
        _as_declared(kernel, data, declared["data_in"].dtype), dtype=declared["data_in"].dtype, device=where
    )
    result = wp.zeros(shape, dtype=declared["data_out"].dtype, device=where)
    arguments = {**defaults_of_kernel(kernel), **kwargs, "data_in": source, "data_out": result}
    wp.launch(kernel, dim=data.shape[:2], inputs=[arguments[name] for name in declared], device=where)
    return result.numpy()


def device_or_cpu(device: str | None) -> str:
    """Return `device` if it is available, else "cpu" (with one warning)."""
    if device in (None, "cpu"):
        return "cpu"
    quiet_warp()
    import warp as wp

    try:
        # Without a driver Warp prints an error each time that it looks for the current device.
        if wp.is_cuda_available():
            return wp.get_device(str(device)).alias
    except (ValueError, RuntimeError):
        pass
    warn_once(f"Annotators ask for device {device!r}, which this machine does not have; the CPU does their work.")
    return "cpu"


def _as_declared(kernel: Any, data: np.ndarray, dtype: Any) -> np.ndarray:
    """Convert `data` to the dtype that the kernel declares; floats may change their size, nothing else."""
    import warp as wp

    wanted = np.dtype(wp.dtype_to_numpy(dtype))
    if data.dtype == wanted or (data.dtype.kind == wanted.kind == "f"):
        return np.ascontiguousarray(data, wanted)
    if {data.dtype, wanted} == {np.dtype(np.uint32), np.dtype(np.int32)}:
        return np.ascontiguousarray(data).view(wanted)
    raise AugmentationError(f"Kernel {kernel.key} reads {wanted}, the annotator gives {data.dtype}.")
