"""The viewer: a page on this machine that shows a stage, a script's frames or a dataset, and lets them be looked at."""
