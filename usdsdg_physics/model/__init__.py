"""The Newton model of a stage: building, stepping and editing it."""
