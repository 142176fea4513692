"""Training with PyTorch from frames in memory: `LiveDataset`. Needs torch."""

try:
    import torch  # noqa: F401  # pyright: ignore[reportMissingImports]
except ImportError as error:
    raise ImportError(
        f"usdsdg.torch gives tensors of PyTorch, and torch cannot be imported ({error}). Install it with `pip install "
        "torch`, or read arrays with usdsdg.stream."
    ) from error

from usdsdg.torch.live_dataset import LiveDataset

__all__ = ["LiveDataset"]
