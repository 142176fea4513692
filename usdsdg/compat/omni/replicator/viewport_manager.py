"""`omni.replicator.core.scripts.utils.viewport_manager`: the class of render products, which scripts name as a type."""

from usdsdg.session.render_products import HydraTexture

__all__ = ["HydraTexture"]
