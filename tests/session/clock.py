"""A clock that tests set, in place of the module `time`."""


class Clock:
    """Time in seconds."""

    now = 0.0

    def monotonic(self) -> float:
        return self.now
