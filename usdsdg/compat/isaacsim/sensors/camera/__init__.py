"""`isaacsim.sensors.camera`: a camera with its images, and several cameras with their images in tiles or batches."""

from usdsdg.compat.isaacsim.sensors.camera.camera import Camera, get_all_camera_objects
from usdsdg.compat.isaacsim.sensors.camera.camera_view import CameraView
from usdsdg.compat.isaacsim.sensors.camera.depth_sensor import SingleViewDepthSensor
from usdsdg.compat.isaacsim.sensors.camera.depth_sensor_asset import SingleViewDepthSensorAsset

__all__ = ["Camera", "CameraView", "SingleViewDepthSensor", "SingleViewDepthSensorAsset", "get_all_camera_objects"]
