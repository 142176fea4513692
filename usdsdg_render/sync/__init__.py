"""Keep the scene in step with the stage: full extraction, then only what changed."""
