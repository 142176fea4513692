"""The command line: one module per command; `program` is the entry point."""
