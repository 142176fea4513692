"""Render products as `rep.vp_manager` and `rep.utils.viewport_manager` know them: their class, and their end."""

from usdsdg.session.render_products import LEGACY_RP_PREFIX, RP_PREFIX_SETTING, HydraTexture, products

__all__ = ["LEGACY_RP_PREFIX", "RP_PREFIX_SETTING", "HydraTexture", "destroy_hydra_textures"]

# As the product of the active viewport is named, which is not one of Replicator's.
_VIEWPORT = "omni_kit_widget_viewport"


def destroy_hydra_textures(context: str | None = None) -> None:
    """Destroy the render products of the current stage, as their `destroy` does, but that of the viewport.

    Args:
        context: The name of a rendering context, such as "Replicator"; all products are of one.
    """
    for product in products():
        if not product.name.startswith(_VIEWPORT):
            product.destroy()
