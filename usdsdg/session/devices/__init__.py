"""Devices: which ones render and simulate, and what is said where their memory is used up."""

from usdsdg.session.devices.choice import physics_device, renderer_device, renderer_device_kind, use_device

__all__ = ["physics_device", "renderer_device", "renderer_device_kind", "use_device"]
