"""`omni.isaac.sensor`: cameras, and sensors of contacts and of motion."""

from usdsdg.compat.isaacsim.sensors.camera import Camera, CameraView, get_all_camera_objects
from usdsdg.compat.isaacsim.sensors.physics import ContactSensor, IMUSensor

__all__ = ["Camera", "CameraView", "ContactSensor", "IMUSensor", "get_all_camera_objects"]
