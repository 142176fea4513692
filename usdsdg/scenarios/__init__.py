"""Ready-made data generation scenarios: each is code, configured by a YAML or JSON file or by a saved stage."""
