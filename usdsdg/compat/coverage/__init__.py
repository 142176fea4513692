"""What scripts use of Isaac Sim and Omniverse, and how much of it is here: `usdsdg compat`."""
