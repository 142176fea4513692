"""Prims of a stage: handles that are kept, copies, instances, types and variants."""
