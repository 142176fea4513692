"""PytorchListener: holds what a PytorchWriter gave it last."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import torch  # pyright: ignore[reportMissingImports]


class PytorchListener:
    """Receives the tensors of a PytorchWriter at each frame; `data` has the last ones, by name."""

    def __init__(self) -> None:
        self.data: dict[str, Any] = {}

    def write_data(self, data: dict[str, Any]) -> None:
        """Replace the tensors of these names."""
        self.data.update(data)

    def get_rgb_data(self) -> torch.Tensor | None:
        """Return the last pictures, uint8 (N, 3, H, W), one for each render product; None before the first frame.

        They are a view of the pictures with alpha, which the next frame replaces and does not overwrite.
        """
        pictures = self.data.get("pytorch_rgb")
        return None if pictures is None else pictures[..., :3].permute(0, 3, 1, 2)
