"""Command line: one module per command; `program` is the entry point, `command_context` what all commands share."""
