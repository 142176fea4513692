"""`python -m usdsdg` is the `usdsdg` program."""

from usdsdg.cli.program import main

main()
