"""Apply to the running simulation what users change on the stage between steps."""
