"""`from omni.replicator.core.scripts.writers_default.cosmoswriter import CosmosWriter`."""

from usdsdg.writers.formats.cosmos.writer_cosmos import CosmosWriter

__all__ = ["CosmosWriter"]
