"""AggregateWriter: the base of writers of files about all frames."""

from __future__ import annotations

from typing import Any

from usdsdg.writers.base import Writer
from usdsdg.writers.options import named_only


class AggregateWriter(Writer):
    """A writer whose `on_final_frame` makes files about all frames: at the end of the run, and when it is detached.

    One that is initialized again makes them of what it has written until then.
    """

    @named_only
    def initialize(self, **kwargs: Any) -> None:
        if self.num_written:  # what was written until now is a dataset of its own
            self.on_final_frame()
        super().initialize(**kwargs)

    def detach(self) -> None:
        super().detach()
        if self.backend is not None:
            self.on_final_frame()
