"""The scene as plain tables on the host, and the table of AOVs."""
