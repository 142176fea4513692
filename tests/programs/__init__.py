"""Random scripts, and the ways to run one that must leave the same files."""
