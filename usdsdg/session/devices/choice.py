"""Where pictures are made, and where bodies are simulated."""

from __future__ import annotations

from usdsdg.errors import PhysicsError
from usdsdg.session.session import current
from usdsdg.warp_start import known_device, quiet_warp


def use_device(device: str | None, *, physics: str | None = None) -> None:
    """Render on "cpu" or "cuda:0", and simulate on `physics`; None: render on CUDA if available, simulate on the CPU.

    One scene is simulated in a sequence of small steps that are written to the stage, for which a core of a CPU is as
    fast as a GPU up to some hundreds of bodies, and faster where several processes would wait for that GPU.

    Raises:
        RenderError: there is no such device to render on. PhysicsError: there is none to simulate on.
    """
    if device not in (None, "cpu"):
        quiet_warp()
        from usdsdg_render.renderer import chosen_device

        chosen_device(device)
    engines = current().engines
    engines.device, engines.physics_device = device, _checked_physics_device(physics or "cpu")
    engines.reset()


def _checked_physics_device(device: str) -> str:
    """Return the name of a device to simulate on.

    Raises:
        PhysicsError: there is no such device.
    """
    if device == "cpu":
        return device  # without Warp, which takes time to load
    try:
        return known_device(device)
    except ValueError as error:
        raise PhysicsError(f"cannot simulate on {device!r}: {error}") from error


def renderer_device() -> str:
    """Return the device that the renderer runs on, or will run on: "cpu" or one such as "cuda:0"."""
    if current().engines.device == "cpu":
        return "cpu"  # a process that lets others render needs no renderer for that
    quiet_warp()
    from usdsdg_render.renderer import chosen_device

    return chosen_device(current().engines.device)


def renderer_device_kind() -> str:
    """Return "cpu" or "cuda": on which kind of device the renderer runs, or will run."""
    return renderer_device().partition(":")[0]


def physics_device() -> str:
    """Return the device that physics runs on, or will run on: "cpu" or one such as "cuda:0"."""
    return current().engines.physics_device
