"""Pictures as tensors of PyTorch."""
