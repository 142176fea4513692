"""The randomization graph: triggers, distributions and actions as nodes."""
