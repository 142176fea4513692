"""`isaacsim.core.api.tasks`: the base of tasks; those of robots are out of scope."""

from usdsdg.compat.isaacsim.core.api.tasks.base_task import BaseTask

__all__ = ["BaseTask"]
