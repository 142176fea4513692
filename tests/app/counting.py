"""A writer that counts."""

import usdsdg as rep
from usdsdg.session.timeline import get_timeline


class Counting(rep.Writer):
    """Records the time of each frame that it receives, and how often the run has ended."""

    def __init__(self) -> None:
        self.annotators = ["camera_params"]
        self.times: list[float] = []
        self.ended = 0

    def write(self, data) -> None:
        self.times.append(get_timeline().get_current_time())

    def on_final_frame(self) -> None:
        self.ended += 1
