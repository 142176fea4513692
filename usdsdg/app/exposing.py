"""The exposure of one frame, while the timeline goes on to its picture."""

from usdsdg.app.app import get_app
from usdsdg.capture.capture import Capture
from usdsdg.capture.render_settings import RenderMode


def expose(capture: Capture, mode: RenderMode, duration: float, *, is_first: bool, bodies_wait: bool) -> None:
    """Advance the timeline, and physics if it plays, by `duration` [s]; motion blur exposes sub-frames in between.

    is_first: whether no frame was captured before; such a frame shows the scene as it was set up.
    bodies_wait: whether physics does not advance.
    """
    if mode.motion_blur and duration > 0.0:
        parts = mode.split(mode.sub_frames)
        capture.open_shutter()
        for part in parts:
            get_app().advance(duration / len(parts), bodies_wait=bodies_wait)
            capture.expose(part)
        return
    if duration > 0.0 and not is_first:
        get_app().advance(duration, bodies_wait=bodies_wait)
    capture.expose(mode)
