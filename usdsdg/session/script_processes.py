"""What the environment tells the processes that a script starts."""

MODULES = "PYTHONPATH"
OPTIONS = "USDSDG_OPTIONS_OF_SCRIPT"  # those of the command that runs the script, as JSON
