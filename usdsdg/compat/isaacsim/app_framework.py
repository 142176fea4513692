"""`isaacsim.AppFramework`: the application without what `SimulationApp` sets up for standalone scripts."""

from __future__ import annotations

from collections.abc import Sequence

from usdsdg import orchestrator
from usdsdg.app.app import App, get_app
from usdsdg.compat import kit_arguments


class AppFramework:
    """The running application, to which Kit's arguments are given: those that name settings or folders count."""

    def __init__(self, name: str = "kit", argv: Sequence[str] | None = None) -> None:
        kit_arguments.apply(argv or ())
        get_app().open_loop()

    @property
    def app(self) -> App:
        return get_app()

    def update(self) -> None:
        get_app().update()

    def close(self) -> None:
        """Wait for all files and end the app, not for tasks that still run."""
        orchestrator.wait_until_complete()
        get_app().close()
