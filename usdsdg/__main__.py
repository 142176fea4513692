"""`python -m usdsdg` is the `usdsdg` program."""

from usdsdg.cli import main

main()
