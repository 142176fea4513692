"""The work of `usdsdg run`: the conditions under which a script runs, its execution, and the remarks at its end."""
