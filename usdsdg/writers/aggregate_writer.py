"""AggregateWriter: the base of writers of files about all frames."""

from __future__ import annotations

from usdsdg.writers.base import Writer


class AggregateWriter(Writer):
    """A writer whose `on_final_frame` makes files about all frames: at the end of the run, and when it is detached."""

    def detach(self) -> None:
        super().detach()
        if self.backend is not None:
            self.on_final_frame()
