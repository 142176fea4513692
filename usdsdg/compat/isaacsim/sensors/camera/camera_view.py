"""`CameraView`: several cameras, with their images in tiles or as a batch."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from usdsdg.annotators import named_annotators
from usdsdg.annotators.annotator import Annotator
from usdsdg.annotators.augmentations.warp_kernel import device_or_cpu
from usdsdg.compat.isaacsim.core.prims.xform_prim import XFormPrim
from usdsdg.compat.isaacsim.core.simulation_manager.simulation import simulation
from usdsdg.compat.isaacsim.sensors.camera import camera_axes as axes
from usdsdg.compat.wrappers.arrays import as_backend, as_numpy, chosen
from usdsdg.create.render_products import render_product_tiled
from usdsdg.errors import ArgumentError, Unsupported, counted, warn_once
from usdsdg.session.render_products import HydraTexture

if TYPE_CHECKING:
    import warp as wp

    from usdsdg.compat.wrappers.arrays import Indices, Values

    # NumPy arrays, Warp arrays or torch tensors, which are not named since torch may be absent.
    Output = np.ndarray | wp.array

# Of each type of output: the annotator and its channels.
OUTPUTS = {
    "rgb": ("rgb", 3),
    "rgba": ("rgb", 4),
    "depth": ("distance_to_image_plane", 1),
    "distance_to_image_plane": ("distance_to_image_plane", 1),
    "distance_to_camera": ("distance_to_camera", 1),
    "normals": ("normals", 4),
    "motion_vectors": ("motion_vectors", 4),
    "semantic_segmentation": ("semantic_segmentation", 1),
    "instance_segmentation_fast": ("instance_segmentation_fast", 1),
    "instance_id_segmentation_fast": ("instance_id_segmentation_fast", 1),
}


class CameraView(XFormPrim):
    """Cameras with a common resolution, and their images after the first update of the application.

    Images of all cameras are the tiles of one render product, row by row from the top left. Arrays of "cuda" are on the
    CPU, with a warning, where there is no such device. Orientations in another convention than USD's are multiplied
    from the left, as in Isaac Sim's class: they are turned about the axes of the world (or parent), unlike `Camera`'s.
    """

    def __init__(
        self,
        prim_paths_expr: str | Sequence[str],
        name: str = "camera_prim_view",
        camera_resolution: tuple[int, int] = (256, 256),
        output_annotators: Sequence[str] | None = None,
        positions: Values | None = None,
        translations: Values | None = None,
        orientations: Values | None = None,
        scales: Values | None = None,
        visibilities: Values | None = None,
        reset_xform_properties: bool = True,
    ) -> None:
        """Wrap the cameras at these paths, of which each part may be a regular expression, and place them.

        Args:
            camera_resolution: Width and height of each image [pixels].
            output_annotators: Types of output, of `OUTPUTS`; rgb and depth by default.
            positions: (N, 3) in the world; `translations` are relative to the parents.

        Raises:
            BadPrim: there are no such prims, or one is no camera.
            ArgumentError: there is no such type of output.
        """
        self._outputs = ["rgb", "depth"] if output_annotators is None else list(output_annotators)
        for output in self._outputs:
            _check_output(output)
        self._annotators: dict[str, Annotator] = {}
        self._product: HydraTexture | None = None
        XFormPrim.__init__(
            self, prim_paths_expr, name, positions=positions, translations=translations, orientations=orientations,
            scales=scales, visibilities=visibilities, reset_xform_properties=reset_xform_properties,
        )  # fmt: skip
        self.camera_resolution = int(camera_resolution[0]), int(camera_resolution[1])
        self._make_product()

    def __del__(self, python_ends: Callable[[], bool] = sys.is_finalizing) -> None:
        product = vars(self).get("_product")
        if product is not None and not python_ends():  # nothing is left of the session then
            product.forget()
            self.destroy()

    def destroy(self) -> None:
        """Detach all annotators and remove the render product."""
        for annotator in self._annotators.values():
            annotator.detach()
        if self._product is not None:
            self._product.destroy()
        self._annotators, self._product = {}, None

    def _make_product(self) -> None:
        self.destroy()
        product = render_product_tiled(
            self.prim_paths, self.camera_resolution, force_new=True, name=f"{self.name}_tiled_sensor"
        )
        # Its annotators are computed when they are read.
        product.captured_on_play = False
        self._product, self.tiled_resolution = product, product.resolution
        for annotator in {OUTPUTS[output][0] for output in self._outputs}:
            self._annotators[annotator] = named_annotators.get(annotator).attach(product)

    def get_render_product_path(self) -> str | None:
        return None if self._product is None else self._product.path

    def set_resolutions(self, resolution: tuple[int, int]) -> None:
        """Set width and height of all images [pixels]; annotators begin anew."""
        size = int(resolution[0]), int(resolution[1])
        if size != self.camera_resolution:
            self.camera_resolution = size
            self._make_product()

    def get_resolutions(self) -> tuple[int, int]:
        return self.camera_resolution

    def get_aspect_ratios(self) -> float:
        width, height = self.camera_resolution
        return width / height

    # --- poses ---
    def get_world_poses(
        self, indices: Indices = None, camera_axes: str = "world", usd: bool = True
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return positions (N, 3) and orientations (N, 4) in the world.

        Raises:
            ArgumentError: there are no such axes.
        """
        positions, orientations = XFormPrim.get_world_poses(self, indices)
        return positions, _in_axes(orientations, camera_axes)

    def set_world_poses(
        self,
        positions: Values | None = None,
        orientations: Values | None = None,
        indices: Indices = None,
        camera_axes: str = "world",
        usd: bool = True,
    ) -> None:
        """Place cameras in the world; what is not given stays.

        Raises:
            ArgumentError: there are no such axes.
        """
        XFormPrim.set_world_poses(self, positions, _of_axes(orientations, camera_axes), indices)

    def get_local_poses(self, indices: Indices = None, camera_axes: str = "world") -> tuple[np.ndarray, np.ndarray]:
        """Return translations (N, 3) and orientations (N, 4) relative to the parents.

        Raises:
            ArgumentError: there are no such axes.
        """
        translations, orientations = XFormPrim.get_local_poses(self, indices)
        return translations, _in_axes(orientations, camera_axes)

    def set_local_poses(
        self,
        translations: Values | None = None,
        orientations: Values | None = None,
        indices: Indices = None,
        camera_axes: str = "world",
        positions: Values | None = None,
    ) -> None:
        """Place cameras relative to their parents (`positions` is another name of `translations`).

        Raises:
            ArgumentError: there are no such axes.
        """
        translations = positions if translations is None else translations
        XFormPrim.set_local_poses(self, translations, _of_axes(orientations, camera_axes), indices)

    # --- images ---
    def get_data(
        self, annotator_type: str, *, tiled: bool = False, out: wp.array | None = None
    ) -> tuple[wp.array, dict[str, Any]]:
        """Return the output of all cameras as a Warp array, and its tables (of segmentations), {} without any.

        The array is (N, H, W, C) or, `tiled`, (rows x H, columns x W, C); empty before the first update. out: an array
        of this shape, or with as many elements, that is filled and returned.

        Raises:
            ArgumentError: there is no such output, or it was not asked for.
        """
        import warp as wp

        array, info = self._read(annotator_type, tiled=tiled)
        if array is None:
            return wp.empty(0, device=device_or_cpu("cuda") if out is None else out.device), {}
        if out is None:
            return wp.array(array, device=device_or_cpu("cuda")), info
        kind = wp.dtype_to_numpy(out.dtype)
        out.assign(np.ascontiguousarray(array.reshape(out.shape), kind))
        return out, info

    def get_rgb_tiled(self, out: Output | None = None, device: str = "cpu") -> Output:
        """Return color, uint8 (rows x H, columns x W, 3): a NumPy array, or for "cuda" a torch tensor.

        out: an array or tensor that is filled and returned.
        """
        return self._output("rgb", out, device, tiled=True)

    def get_depth_tiled(self, out: Output | None = None, device: str = "cpu") -> Output:
        """Return distances along the optical axes [m], float32 (rows x H, columns x W, 1), as `get_rgb_tiled`."""
        return self._output("depth", out, device, tiled=True)

    def get_rgb(self, out: Output | None = None) -> Output:
        """Return color, a torch tensor of uint8 (N, H, W, 3); or fill `out` and return it."""
        return self._output("rgb", out, "cuda", tiled=False)

    def get_depth(self, out: Output | None = None) -> Output:
        """Return distances along the optical axes [m], a torch tensor of float32 (N, H, W, 1); or fill `out`."""
        return self._output("depth", out, "cuda", tiled=False)

    def _output(self, output: str, out: Any, device: str, *, tiled: bool) -> Any:
        array, _ = self._read(output, tiled=tiled)
        array = np.zeros(0, np.float32) if array is None else array
        if out is None:
            return array if device == "cpu" else _torch_tensor(array, device)
        if array.size:
            shaped = array.reshape(tuple(out.shape))
            if isinstance(out, np.ndarray):
                out[...] = shaped
            else:
                out.copy_(_torch_tensor(shaped, "cpu"))
        return out

    def _read(self, output: str, *, tiled: bool) -> tuple[np.ndarray | None, dict[str, Any]]:
        """Return an array with a last axis of channels, and the tables; None before the first update."""
        _check_output(output)
        name, channels = OUTPUTS[output]
        if name not in self._annotators:
            raise ArgumentError(
                f"{self.name}: output {output!r} was not asked for; give output_annotators={[*self._outputs, output]!r}"
            )
        data = self._annotators[name].get_data()
        array, info = (data["data"], data["info"]) if isinstance(data, dict) else (data, {})
        if not array.size:
            return None, {}
        array = array.reshape(*array.shape[:2], -1)[..., :channels]
        return (array if tiled else self._batch(array)), info

    def _batch(self, whole: np.ndarray) -> np.ndarray:
        """Return the tiles (N, H, W, C) of an image."""
        width, height = self.camera_resolution
        columns = self.tiled_resolution[0] // width
        tiles = whole.reshape(-1, height, columns, width, whole.shape[-1]).swapaxes(1, 2)
        return np.ascontiguousarray(tiles.reshape(-1, height, width, whole.shape[-1])[: self.count])

    # --- lenses ---
    def get_focal_lengths(self, indices: Indices = None) -> list[float]:
        """Return focal lengths [stage units]."""
        return [value / 10.0 for value in self._get("focalLength", indices)]

    def set_focal_lengths(self, values: Sequence[float], indices: Indices = None) -> None:
        """Set focal lengths [stage units]."""
        self._set("focalLength", [value * 10.0 for value in values], indices)

    def get_focus_distances(self, indices: Indices = None) -> list[float]:
        """Return focus distances [stage units]."""
        return self._get("focusDistance", indices)

    def set_focus_distances(self, values: Sequence[float], indices: Indices = None) -> None:
        self._set("focusDistance", values, indices)

    def get_lens_apertures(self, indices: Indices = None) -> list[float]:
        """Return f-numbers."""
        return self._get("fStop", indices)

    def set_lens_apertures(self, values: Sequence[float], indices: Indices = None) -> None:
        self._set("fStop", values, indices)

    def get_horizontal_apertures(self, indices: Indices = None) -> list[float]:
        """Return widths of the sensors [tenths of stage units]."""
        return self._get("horizontalAperture", indices)

    def set_horizontal_apertures(self, values: Sequence[float], indices: Indices = None) -> None:
        self._set("horizontalAperture", values, indices)

    def get_vertical_apertures(self, indices: Indices = None) -> list[float]:
        """Return heights of the sensors [tenths of stage units]."""
        return self._get("verticalAperture", indices)

    def set_vertical_apertures(self, values: Sequence[float], indices: Indices = None) -> None:
        self._set("verticalAperture", values, indices)

    def get_projection_types(self, indices: Indices = None) -> list[str]:
        """Return the older attributes cameraProjectionType, or "pinhole"."""
        return [value or "pinhole" for value in self._get("cameraProjectionType", indices)]

    def set_projection_types(self, values: Sequence[str], indices: Indices = None) -> None:
        """Set the older attributes cameraProjectionType."""
        from pxr import Sdf

        for index in chosen(indices, self.count):
            self.prims[index].CreateAttribute("cameraProjectionType", Sdf.ValueTypeNames.Token)
        self._set("cameraProjectionType", values, indices)

    def get_projection_modes(self, indices: Indices = None) -> list[str]:
        """Return "perspective" or "orthographic" of each."""
        return self._get("projection", indices)

    def set_projection_modes(self, values: Sequence[str], indices: Indices = None) -> None:
        self._set("projection", values, indices)

    def get_stereo_roles(self, indices: Indices = None) -> list[str]:
        """Return "mono", "left" or "right" of each."""
        return self._get("stereoRole", indices)

    def set_stereo_roles(self, values: Sequence[str], indices: Indices = None) -> None:
        self._set("stereoRole", values, indices)

    def get_shutter_properties(self, indices: Indices = None) -> list[tuple[float, float]]:
        """Return when each shutter opens and closes [time codes]."""
        return list(zip(self._get("shutter:open", indices), self._get("shutter:close", indices), strict=True))

    def set_shutter_properties(self, values: Sequence[tuple[float, float]], indices: Indices = None) -> None:
        """Set when shutters open and close; 0 leaves a value."""
        for which, name in enumerate(("shutter:open", "shutter:close")):
            self._set(name, [value[which] for value in values], indices, skip_zero=True)

    def _get(self, name: str, indices: Indices) -> list[Any]:
        return [self.prims[index].GetAttribute(name).Get() for index in chosen(indices, self.count)]

    def _set(self, name: str, values: Sequence[Any], indices: Indices, *, skip_zero: bool = False) -> None:
        where = chosen(indices, self.count)
        if len(values) != len(where):
            given = counted(len(values), f"value of {name} is", f"values of {name} are")
            raise ArgumentError(f"{self.name}: {given} given for {counted(len(where), 'camera')}")
        for index, value in zip(where, values, strict=True):
            if value or not skip_zero:
                self.prims[index].GetAttribute(name).Set(value)


def _check_output(output: str) -> None:
    if output not in OUTPUTS:
        raise ArgumentError(f"CameraView: there is no output {output!r}; expected {', '.join(OUTPUTS)}")


def _in_axes(orientations: Any, camera_axes: str) -> np.ndarray:
    state = simulation()
    turned = axes.from_usd(as_numpy(orientations), camera_axes, left=True).astype(np.float32)
    return as_backend(turned, state.backend, state.device)


def _of_axes(orientations: Any, camera_axes: str) -> np.ndarray | None:
    if orientations is None:
        return None
    return axes.to_usd(as_numpy(orientations), camera_axes, left=True)


def _torch_tensor(array: np.ndarray, device: str) -> Any:
    """Return a torch tensor on a device; on the CPU, with a warning, where there is no such device.

    Raises:
        Unsupported: torch is not installed.
    """
    try:
        import torch  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise Unsupported(
            "CameraView: torch is not installed, and this output is a torch tensor; pip install torch, or use "
            "get_data(...), whose Warp arrays have numpy(), or get_rgb_tiled and get_depth_tiled with device='cpu'"
        ) from None
    tensor = torch.from_numpy(np.ascontiguousarray(array))
    if device != "cpu" and not torch.cuda.is_available():
        warn_once("CameraView: there is no CUDA device, so torch tensors are on the CPU")
        return tensor
    return tensor.to(device)
