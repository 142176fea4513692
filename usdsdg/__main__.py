"""`python -m usdsdg` is the `usdsdg` program."""

from usdsdg_program import main

main()
