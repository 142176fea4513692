"""PytorchWriter: pictures as tensors, given to a listener at each frame."""

import os
from importlib import import_module
from typing import Any

from usdsdg.annotators import named_annotators
from usdsdg.errors import Unsupported, WriterError, warn_once
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.backends.group import make_backend
from usdsdg.writers.base import Writer
from usdsdg.writers.files import as_array, write_image
from usdsdg.writers.options import typed

RGB = "LdrColor"


class PytorchWriter(Writer):
    """Gives a PytorchListener the pictures of each frame, uint8 (N, H, W, 4), one for each render product.

    With `output_dir` or `backend` it also writes them, as `rgb_N_<render product>.png`, `rgb_N_LdrColor.png` for the
    only one, or `rgb_N.png` of a tiled sensor. The picture of one render product is not copied to become a tensor, on
    the CPU or on the device; those of several are stacked, so their sizes must be equal. Needs torch.
    """

    version = "0.0.1"
    data_structure = "renderProduct"

    @typed
    def __init__(
        self,
        listener: Any,
        output_dir: str | os.PathLike | None = None,
        tiled_sensor: bool = False,
        device: Any = "cuda",
        *,
        backend: BaseBackend | None = None,
    ) -> None:
        """
        listener: a PytorchListener, or anything with its `write_data`.
        output_dir: where PNGs are written; None: nowhere.
        tiled_sensor: whether the render product shows cameras in tiles; it changes the names of files.
        device: where tensors are, as torch names devices; on the CPU, with a warning, if torch has no CUDA device.

        Raises:
            WriterError: `listener` is none, or torch has no such `device`.
            Unsupported: torch is not installed.
            OutputNotWritable: output_dir cannot be written to.
        """
        if not callable(getattr(listener, "write_data", None)):
            raise WriterError(f"PytorchWriter: listener is {listener!r}; expected a PytorchListener.")
        self._torch = _torch()
        self.listener, self.device = listener, _available(self._torch, device)
        self.backend = make_backend("PytorchWriter", output_dir, backend) if output_dir or backend else None
        self._tiled = tiled_sensor
        self._frame_id = 0
        on = str(self.device) if self._torch.device(self.device).type == "cuda" else None
        self.annotators = [named_annotators.get(RGB, device=on)]

    def write(self, data: dict[str, Any]) -> None:
        pictures = {product: seen[RGB]["data"] for product, seen in data["renderProducts"].items()}
        tensors = [self._tensor(picture) for picture in pictures.values()]
        sizes = {tuple(each.shape) for each in tensors}
        if len(sizes) > 1:
            listed = ", ".join(f"{shape[1]}x{shape[0]}" for shape in sorted(sizes))
            raise WriterError(f"PytorchWriter: render products of several sizes ({listed}) do not make one tensor.")
        self._write_files(pictures)
        batch = tensors[0].unsqueeze(0) if len(tensors) == 1 else self._torch.stack(tensors)
        self.listener.write_data({"pytorch_rgb": batch, "device": self.device})
        self._frame_id += 1

    def _tensor(self, picture: Any) -> Any:
        """Return a picture as a tensor that shares its memory where that is on the device."""
        if hasattr(picture, "__cuda_array_interface__") or hasattr(picture, "numpy"):
            import warp as wp

            return wp.to_torch(picture).to(self.device)
        return self._torch.from_numpy(picture).to(self.device)

    def _write_files(self, pictures: dict[str, Any]) -> None:
        if self.backend is None:
            return
        several = max(len(self.render_products), len(pictures)) > 1
        for product, picture in pictures.items():
            name = "" if self._tiled else f"_{product if several else RGB}"
            # A copy, since the listener's tensor shares the picture's memory.
            image = as_array(picture).copy()
            self.backend.schedule(write_image, path=f"rgb_{self._frame_id}{name}.png", data=image)


def _torch() -> Any:
    """Return torch, which is large and loaded only for this writer.

    Raises:
        Unsupported: it is not installed.
    """
    try:
        return import_module("torch")
    except ImportError as error:
        raise Unsupported(
            f"PytorchWriter gives tensors of PyTorch, and torch cannot be imported ({error}). Install it with "
            "`pip install torch`, or read arrays with an annotator's get_data()."
        ) from error


def _available(torch: Any, device: Any) -> Any:
    """Return the device, or "cpu", with a warning, in place of a CUDA device that torch does not have.

    Raises:
        WriterError: torch names no device so, or has no such device.
    """
    try:
        torch.device(device)
    except (TypeError, RuntimeError):
        raise WriterError(
            f"PytorchWriter: device is {device!r}; expected a device of torch: 'cpu' or 'cuda'."
        ) from None
    if torch.device(device).type == "cuda" and not torch.cuda.is_available():
        warn_once(f"PytorchWriter: torch has no CUDA device, so tensors are on the CPU instead of {str(device)!r}")
        return "cpu"
    try:
        torch.empty(1, device=device)
    except (AssertionError, NotImplementedError, RuntimeError):
        raise WriterError(f"PytorchWriter: torch has no device {str(device)!r} here; give 'cpu' or 'cuda'.") from None
    return device
