"""`isaacsim.core.api.sensors`: contact forces on prims."""

from usdsdg.compat.isaacsim.core.prims.contact_view import RigidContactView

__all__ = ["RigidContactView"]
