"""The work of `usdsdg run`: the conditions under which a script runs, its execution, and what is said at its end."""
