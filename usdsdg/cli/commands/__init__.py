"""The commands: one module for each, which `usdsdg.cli.app` lists."""
