"""The object-based scenario: its configuration, scene, randomizers and loop."""
