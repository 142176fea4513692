"""Commands of the toolbar, which play the timeline."""

from usdsdg.compat.omni.kit.commands.registry import command
from usdsdg.session.timeline import get_timeline


@command("ToolbarPlayButtonClicked")
def play() -> None:
    """Play the timeline."""
    get_timeline().play()


@command("ToolbarPauseButtonClicked")
def pause() -> None:
    """Pause the timeline."""
    get_timeline().pause()


@command("ToolbarStopButtonClicked")
def stop() -> None:
    """Stop the timeline."""
    get_timeline().stop()
