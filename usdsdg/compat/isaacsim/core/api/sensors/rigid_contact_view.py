"""`isaacsim.core.api.sensors.rigid_contact_view`."""

from usdsdg.compat.isaacsim.core.prims.contact_view import RigidContactView

__all__ = ["RigidContactView"]
