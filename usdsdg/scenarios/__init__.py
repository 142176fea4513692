"""Ready-made jobs: a scenario as code, its choices as a configuration file."""
