"""Options that several commands have, and what they do around a command."""
