"""Command line: `program` is the entry point, `commands` has a module for each, `options` what they share."""
