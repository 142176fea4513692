"""`isaacsim.core.api.sensors`: contact forces on prims, and the base of a script's own sensors."""

from usdsdg.compat.isaacsim.core.api.sensors.base_sensor import BaseSensor
from usdsdg.compat.isaacsim.core.prims.contact_view import RigidContactView

__all__ = ["BaseSensor", "RigidContactView"]
