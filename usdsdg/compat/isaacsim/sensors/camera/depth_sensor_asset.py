"""`SingleViewDepthSensorAsset`: an asset with cameras and the render products that say how they measure depth."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike
from pxr import Usd

from usdsdg.compat.isaacsim.core.prims import SingleXFormPrim
from usdsdg.compat.isaacsim.core.utils.stage import add_reference_to_stage
from usdsdg.compat.isaacsim.sensors.camera.depth_sensor import PREFIX, SCHEMA, SingleViewDepthSensor
from usdsdg.compat.wrappers.prim_paths import existing_prim
from usdsdg.errors import ArgumentError, warn_once
from usdsdg.session.stage_context import current_stage


class SingleViewDepthSensorAsset:
    """The depth sensors of an asset: one for each render product in it that has `OmniSensorDepthSensorSingleViewAPI`.

    These are templates: `initialize` copies their settings to the render products of the sensors.
    """

    def __init__(
        self,
        prim_path: str,
        asset_path: str,
        position: ArrayLike | None = None,
        translation: ArrayLike | None = None,
        orientation: ArrayLike | None = (1.0, 0.0, 0.0, 0.0),
    ) -> None:
        """Reference a file, or a URL under the assets root, at `prim_path`, with a pose in the world or in its parent.

        Raises:
            AssetError: the file is missing or cannot be referenced.
        """
        prim = add_reference_to_stage(asset_path, prim_path)
        # As in Isaac Sim, the position in the world goes first.
        place = {"position": position} if position is not None else {"translation": translation}
        SingleXFormPrim(prim_path, orientation=orientation, **place)  # pyright: ignore[reportArgumentType]
        self._sensors: dict[str, tuple[Usd.Prim, SingleViewDepthSensor]] = {}
        for template in Usd.PrimRange(prim):
            if template.GetTypeName() == "RenderProduct" and SCHEMA in template.GetAppliedSchemas():
                self._add(template)
        if not self._sensors:
            warn_once(f"{asset_path}: the asset at {prim_path} has no render product with {SCHEMA}, so no depth sensor")

    def _add(self, template: Usd.Prim) -> None:
        cameras = template.GetRelationship("camera").GetTargets()
        if len(cameras) != 1:
            warn_once(f"{template.GetPath()} names {len(cameras)} cameras, and not one: it is no depth sensor")
            return
        resolution = template.GetAttribute("resolution").Get()
        size = None if resolution is None else (int(resolution[0]), int(resolution[1]))
        self._sensors[str(cameras[0])] = template, SingleViewDepthSensor(str(cameras[0]), resolution=size)

    def initialize(self, physics_sim_view: object = None, attach_rgb_annotator: bool = False) -> None:
        """Make the render products of all sensors, with the settings of their templates, and turn them on."""
        for template, sensor in self._sensors.values():
            sensor.initialize(physics_sim_view, attach_rgb_annotator)
            product = existing_prim(str(sensor.get_render_product_path()))
            for attribute in template.GetAttributes():
                name = attribute.GetName()
                if name.startswith(PREFIX) and (value := attribute.Get()) is not None:
                    product.GetAttribute(name).Set(value)
            sensor.set_enabled(True)

    def get_all_depth_sensors(self) -> list[SingleViewDepthSensor]:
        return [sensor for _, sensor in self._sensors.values()]

    def get_all_depth_sensor_paths(self) -> list[str]:
        """Return the paths of the cameras."""
        return list(self._sensors)

    def get_child_depth_sensor(self, camera_prim_path: str) -> SingleViewDepthSensor:
        """Return the sensor of a camera.

        Raises:
            KeyError: the asset has none at that path.
        """
        if str(camera_prim_path) not in self._sensors:
            known = ", ".join(self._sensors) or "none"
            raise KeyError(f"there is no depth sensor at {camera_prim_path}; the asset's are {known}")
        return self._sensors[str(camera_prim_path)][1]

    @staticmethod
    def add_template_render_product(parent_prim_path: str, camera_prim_path: str, **kwargs: Any) -> Usd.Prim:
        """Define a template below a prim for a camera, with values of its attributes by their names; return it.

        Raises:
            BadPrim: there is no such camera.
            ArgumentError: the prim is no camera, or the template has no attribute of a name.
        """
        camera = existing_prim(str(camera_prim_path))
        if camera.GetTypeName() != "Camera":
            raise ArgumentError(f"{camera_prim_path} is a {camera.GetTypeName() or 'prim without a type'}, no Camera")
        path = f"{parent_prim_path.rstrip('/')}/{camera.GetName()}_render_product"
        template = current_stage().DefinePrim(path, "RenderProduct")
        template.ApplyAPI(SCHEMA)
        template.CreateRelationship("camera").SetTargets([camera.GetPath()])
        for name, value in kwargs.items():
            if not template.HasAttribute(name):
                raise ArgumentError(f"{path} has no attribute {name!r}; those of the sensor begin with {PREFIX}")
            template.GetAttribute(name).Set(value)
        return template
