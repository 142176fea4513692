"""usdsdg: synthetic data from USD scenes, with the Replicator API."""

__version__ = "0.1.0"
