"""Triggers, distributions and actions as nodes: what fires, what it draws, what it writes."""
