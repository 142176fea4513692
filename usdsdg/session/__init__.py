"""The state of one process: the current stage, settings, timeline, engines, progress."""
