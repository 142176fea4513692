"""BasicWriter: separate files for every annotator."""

import json
import os
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, cast

import numpy as np

from usdsdg.annotators import named_annotators
from usdsdg.annotators.packed_colors import unpacked
from usdsdg.annotators.payload import by_annotator
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.backends.group import make_backend
from usdsdg.writers.base import Writer
from usdsdg.writers.files import checked_image_format, checked_padding, write_image, write_json, write_np
from usdsdg.writers.options import label_params, typed

Step = Callable[..., None]

_BOXES = ("bounding_box_2d_tight", "bounding_box_2d_loose", "bounding_box_3d")
_FAST = "_fast"  # ends names of annotators, as in Replicator, but not of files
_OWN_BOXES = ("bounding_box_2d_amodal", "oriented_bounding_box_2d", "oriented_bounding_box_2d_amodal")


class BasicWriter(Writer):
    """Writes `<annotator>_NNNN.<extension>`; with several render products in a folder per product and annotator.

    All files of one product and frame are one job, images and arrays before the JSON that describes them.
    """

    version = "0.0.2"
    data_structure = "annotator"
    shares_arrays = True
    only_stores_pictures = True

    @typed
    def __init__(
        self,
        output_dir: str | os.PathLike | None = None,
        s3_bucket: str | None = None,
        s3_region: str | None = None,
        s3_endpoint: str | None = None,
        semantic_types: list[str] | str | None = None,
        rgb: bool = False,
        bounding_box_2d_tight: bool = False,
        bounding_box_2d_loose: bool = False,
        semantic_segmentation: bool = False,
        instance_id_segmentation: bool = False,
        instance_segmentation: bool = False,
        distance_to_camera: bool = False,
        distance_to_image_plane: bool = False,
        bounding_box_3d: bool = False,
        occlusion: bool = False,
        normals: bool = False,
        motion_vectors: bool = False,
        camera_params: bool = False,
        pointcloud: bool = False,
        pointcloud_include_unlabelled: bool = False,
        image_output_format: str = "png",
        colorize_semantic_segmentation: bool = True,
        colorize_instance_id_segmentation: bool = True,
        colorize_instance_segmentation: bool = True,
        colorize_depth: bool = False,
        skeleton_data: bool = False,
        frame_padding: int = 4,
        semantic_filter_predicate: str | None = None,
        use_common_output_dir: bool = False,
        backend: BaseBackend | None = None,
        *,
        amodal_instance_segmentation: bool = False,
        visibility: bool = False,
        truncation: bool = False,
        bounding_box_2d_amodal: bool = False,
        oriented_bounding_box_2d: bool = False,
        oriented_bounding_box_2d_amodal: bool = False,
        object_coordinates: bool = False,
        keypoints: bool = False,
        dense_correspondence: bool | str = False,
    ) -> None:
        """
        s3_bucket, s3_region, s3_endpoint: write to a bucket, below `output_dir` as a prefix; see `S3Backend`.
        semantic_types, semantic_filter_predicate: labels to use, as types or as a predicate; default "class:*".
        pointcloud_include_unlabelled: keep points of gprims without such labels.
        colorize_depth: also write depth as a gray image on a logarithmic scale, white at the smallest distance of the
            frame and black at the largest, and where nothing is hit.
        use_common_output_dir: with several render products, `<annotator>/<product>_...` instead of
            `<product>/<annotator>/...`.
        amodal_instance_segmentation and the following: the annotators of these names, beyond Replicator's.
        dense_correspondence: True follows the points of the previous picture to this one; the path of a camera or
            render product finds the points of this picture in that one's.

        Raises:
            WriterError: two options exclude each other, a value does not exist, or there is nowhere to write.
            OutputNotWritable: output_dir or the bucket cannot be written to.
            Unsupported: a bucket without obstore.
        """
        labels = label_params("BasicWriter", semantic_types, semantic_filter_predicate)
        wanted: dict[str, tuple[bool, Mapping[str, Any]]] = {
            "rgb": (rgb, {}),
            "normals": (normals, {}),
            "distance_to_camera": (distance_to_camera, {}),
            "distance_to_image_plane": (distance_to_image_plane, {}),
            "motion_vectors": (motion_vectors, {}),
            "semantic_segmentation": (semantic_segmentation, labels | {"colorize": colorize_semantic_segmentation}),
            "instance_id_segmentation_fast": (
                instance_id_segmentation, {"colorize": colorize_instance_id_segmentation},
            ),
            "instance_segmentation_fast": (
                instance_segmentation, labels | {"colorize": colorize_instance_segmentation},
            ),
            "bounding_box_2d_tight_fast": (bounding_box_2d_tight, labels),
            "bounding_box_2d_loose_fast": (bounding_box_2d_loose, labels),
            "bounding_box_3d_fast": (bounding_box_3d, labels),
            "occlusion": (occlusion, labels),
            "camera_params": (camera_params, {}),
            "pointcloud": (pointcloud, labels | {"includeUnlabelled": pointcloud_include_unlabelled}),
            "skeleton_data": (skeleton_data, {}),
            "amodal_instance_segmentation": (amodal_instance_segmentation, labels | {"encoding": "rle"}),
            "visibility": (visibility, labels),
            "truncation": (truncation, labels),
            "bounding_box_2d_amodal": (bounding_box_2d_amodal, labels),
            "oriented_bounding_box_2d": (oriented_bounding_box_2d, labels),
            "oriented_bounding_box_2d_amodal": (oriented_bounding_box_2d_amodal, labels),
            "object_coordinates": (object_coordinates, labels),
            "keypoints": (keypoints, labels),
            "dense_correspondence": (bool(dense_correspondence), _other_picture(dense_correspondence)),
        }  # fmt: skip
        self.annotators = [named_annotators.get(name, params) for name, (asked, params) in wanted.items() if asked]
        self.backend = make_backend(
            "BasicWriter", output_dir, backend, bucket=s3_bucket, region=s3_region, endpoint_url=s3_endpoint
        )
        # Subclasses read these attributes, which have Replicator's names and first values.
        self._backend, self._output_dir = self.backend, output_dir
        self._image_output_format = checked_image_format(image_output_format)
        self._frame_padding = checked_padding(frame_padding)
        self._frame_id, self._sequence_id = 0, cast(str, 0)
        self.colorize_semantic_segmentation = colorize_semantic_segmentation
        self.colorize_instance_id_segmentation = colorize_instance_id_segmentation
        self.colorize_instance_segmentation = colorize_instance_segmentation
        self.colorize_depth = colorize_depth
        self.use_common_output_dir = use_common_output_dir

    def write(self, data: dict[str, Any]) -> None:
        self._follow_sequence(data)
        by_product: dict[str, list[Step]] = {}
        for annotator, products in by_annotator(data).items():
            name = annotator.removesuffix(_FAST)
            for product, seen in products.items():
                if name not in _STEPS and not isinstance(seen, Mapping):
                    continue  # camera and resolution, which are listed next to the annotators
                # Folders must not change when a product is disabled for a frame.
                several = max(len(self.render_products), len(products)) > 1
                folder = self._folder(name, product, several=several)
                by_product.setdefault(product, []).extend(self._steps(name, folder, seen))
        for steps in by_product.values():
            self._schedule(steps)
        self._frame_id += 1

    def _steps(self, name: str, folder: str, seen: Mapping[str, Any]) -> list[Step]:
        number = f"{self._sequence_id}{self._frame_id:0{self._frame_padding}d}"
        return _STEPS.get(name, _array_steps)(self, name, folder, number, seen)

    def _schedule(self, steps: list[Step]) -> None:
        assert self.backend is not None
        # JSON last, after the files that it describes.
        self.backend.schedule_together(sorted(steps, key=lambda step: step.func is write_json))

    def skip(self, data: dict[str, Any]) -> None:
        self._follow_sequence(data)
        self._frame_id += 1

    def _follow_sequence(self, data: dict[str, Any]) -> None:
        """Count frames from 0 again where a trigger of time has fired; file names begin with how often each has."""
        outputs = data.get("trigger_outputs") or {}
        sequence = "".join(f"{count}_" for name, count in reversed(outputs.items()) if "on_time" in name)
        if sequence != self._sequence_id:
            self._frame_id, self._sequence_id = 0, sequence

    def _folder(self, name: str, product: str, *, several: bool) -> str:
        """Return the prefix of the file name."""
        if not several:
            return ""
        return f"{name}/{product}_" if self.use_common_output_dir else f"{product}/{name}/"

    # Replicator's methods, for subclasses with a `write` of their own: each writes the files of one annotator of the
    # current frame. `anno_rp_data` is what the payload has of it, `output_path` the beginning of the files' paths.

    def _write_rgb(self, anno_rp_data: Mapping[str, Any], output_path: str) -> None:
        self._schedule(self._steps("rgb", output_path, anno_rp_data))

    def _write_normals(self, anno_rp_data: Mapping[str, Any], output_path: str) -> None:
        self._schedule(self._steps("normals", output_path, anno_rp_data))

    def _write_distance_to_camera(self, anno_rp_data: Mapping[str, Any], output_path: str) -> None:
        self._schedule(self._steps("distance_to_camera", output_path, anno_rp_data))

    def _write_distance_to_image_plane(self, anno_rp_data: Mapping[str, Any], output_path: str) -> None:
        self._schedule(self._steps("distance_to_image_plane", output_path, anno_rp_data))

    def _write_semantic_segmentation(self, anno_rp_data: Mapping[str, Any], output_path: str) -> None:
        self._schedule(self._steps("semantic_segmentation", output_path, anno_rp_data))

    def _write_instance_id_segmentation(self, anno_rp_data: Mapping[str, Any], output_path: str) -> None:
        self._schedule(self._steps("instance_id_segmentation", output_path, anno_rp_data))

    def _write_instance_segmentation(self, anno_rp_data: Mapping[str, Any], output_path: str) -> None:
        self._schedule(self._steps("instance_segmentation", output_path, anno_rp_data))

    def _write_motion_vectors(self, anno_rp_data: Mapping[str, Any], output_path: str) -> None:
        self._schedule(self._steps("motion_vectors", output_path, anno_rp_data))

    def _write_occlusion(self, anno_rp_data: Mapping[str, Any], output_path: str) -> None:
        self._schedule(self._steps("occlusion", output_path, anno_rp_data))

    def _write_camera_params(self, anno_rp_data: Mapping[str, Any], output_path: str) -> None:
        self._schedule(self._steps("camera_params", output_path, anno_rp_data))

    def _write_pointcloud(self, anno_rp_data: Mapping[str, Any], output_path: str) -> None:
        self._schedule(self._steps("pointcloud", output_path, anno_rp_data))

    def _write_skeleton(self, anno_rp_data: Mapping[str, Any], output_path: str) -> None:
        self._schedule(self._steps("skeleton_data", output_path, anno_rp_data))

    def _write_bounding_box_data(self, anno_rp_data: Mapping[str, Any], bbox_type: str, output_path: str) -> None:
        self._schedule(self._steps(f"bounding_box_{bbox_type}", output_path, anno_rp_data))


# One function per group of annotators: (writer, name, folder, number, flat annotation) → steps.


def _rgb_steps(writer: BasicWriter, name: str, folder: str, number: str, seen: Mapping[str, Any]) -> list[Step]:
    return [partial(write_image, path=f"{folder}{name}_{number}.{writer._image_output_format}", data=seen["data"])]


def _normals_steps(writer: BasicWriter, name: str, folder: str, number: str, seen: Mapping[str, Any]) -> list[Step]:
    path = f"{folder}{name}_{number}.png"
    return [partial(_write_converted, path=path, data=seen["data"], convert=colorize_normals)]


def _depth_steps(writer: BasicWriter, name: str, folder: str, number: str, seen: Mapping[str, Any]) -> list[Step]:
    steps = _array_steps(writer, name, folder, number, seen)
    if writer.colorize_depth:
        path = f"{folder}{name}_{number}.png"
        steps.append(partial(_write_converted, path=path, data=seen["data"], convert=colorize_distance))
    return steps


def _array_steps(writer: BasicWriter, name: str, folder: str, number: str, seen: Mapping[str, Any]) -> list[Step]:
    """Write the array, or the info if there is none; also for annotators that users added."""
    if "data" not in seen:
        return [partial(write_json, path=f"{folder}{name}_{number}.json", data=dict(seen))]
    return [partial(write_np, path=f"{folder}{name}_{number}.npy", data=seen["data"])]


def _segmentation_steps(
    writer: BasicWriter, name: str, folder: str, number: str, seen: Mapping[str, Any]
) -> list[Step]:
    tables = {"labels" if name == "semantic_segmentation" else "mapping": seen["idToLabels"]}
    if "idToSemantics" in seen:
        tables["semantics_mapping"] = seen["idToSemantics"]
    return [
        partial(write_image, path=f"{folder}{name}_{number}.png", data=unpacked(seen)),
        *(
            # Colors, which are tuples, are no keys of JSON.
            partial(
                write_json,
                path=f"{folder}{name}_{t}_{number}.json",
                data={str(key): each for key, each in table.items()},
            )
            for t, table in tables.items()
        ),
    ]


def _box_steps(writer: BasicWriter, name: str, folder: str, number: str, seen: Mapping[str, Any]) -> list[Step]:
    return [
        partial(write_np, path=f"{folder}{name}_{number}.npy", data=seen["data"]),
        partial(write_json, path=f"{folder}{name}_labels_{number}.json", data=seen["idToLabels"]),
        partial(write_json, path=f"{folder}{name}_prim_paths_{number}.json", data=seen["primPaths"]),
    ]


def _camera_steps(writer: BasicWriter, name: str, folder: str, number: str, seen: Mapping[str, Any]) -> list[Step]:
    return [partial(write_json, path=f"{folder}{name}_{number}.json", data=dict(seen))]


def _pointcloud_steps(writer: BasicWriter, name: str, folder: str, number: str, seen: Mapping[str, Any]) -> list[Step]:
    arrays = {
        "": seen["data"],
        "rgb_": seen["pointRgb"],
        "normals_": seen["pointNormals"],
        "semantic_": seen["pointSemantic"],
        "instance_": seen["pointInstance"],
    }
    return [partial(write_np, path=f"{folder}{name}_{kind}{number}.npy", data=a) for kind, a in arrays.items()]


def _skeleton_steps(writer: BasicWriter, name: str, folder: str, number: str, seen: Mapping[str, Any]) -> list[Step]:
    told = {f"skeleton_{index}": each for index, each in enumerate(json.loads(seen["skeletonData"]))}
    return [partial(write_json, path=f"{folder}skeleton_{number}.json", data=told)]


def _table_steps(writer: BasicWriter, name: str, folder: str, number: str, seen: Mapping[str, Any]) -> list[Step]:
    """Write the array, if there is one, and the rest as one file."""
    info = {key: value for key, value in seen.items() if key != "data"}
    steps = [partial(write_json, path=f"{folder}{name}_info_{number}.json", data=info)]
    return steps + (_array_steps(writer, name, folder, number, seen) if "data" in seen else [])


def _coordinate_steps(writer: BasicWriter, name: str, folder: str, number: str, seen: Mapping[str, Any]) -> list[Step]:
    image = partial(_write_converted, path=f"{folder}{name}_{number}.png", data=seen["data"], convert=eight_bit)
    return [image, *_table_steps(writer, name, folder, number, seen)]


def _correspondence_steps(
    writer: BasicWriter, name: str, folder: str, number: str, seen: Mapping[str, Any]
) -> list[Step]:
    other = {"camera": seen["camera"], "resolution": seen["resolution"]}
    return [
        *_table_steps(writer, name, folder, number, {"data": seen["data"], **other}),
        partial(write_image, path=f"{folder}{name}_visibility_{number}.png", data=seen["visibility"]),
    ]


def _other_picture(asked: bool | str) -> dict[str, Any]:
    """Return the parameters of dense_correspondence."""
    return {"camera": asked} if isinstance(asked, str) else {"captures": int(asked)}


_STEPS: dict[str, Callable[..., list[Step]]] = {
    "skeleton_data": _skeleton_steps,
    "rgb": _rgb_steps,
    "normals": _normals_steps,
    "distance_to_camera": _depth_steps,
    "distance_to_image_plane": _depth_steps,
    "camera_params": _camera_steps,
    "pointcloud": _pointcloud_steps,
    **dict.fromkeys(
        ("semantic_segmentation", "instance_id_segmentation", "instance_segmentation"), _segmentation_steps
    ),
    **dict.fromkeys((*_BOXES, *_OWN_BOXES), _box_steps),
    **dict.fromkeys(("amodal_instance_segmentation", "visibility", "keypoints"), _table_steps),
    "object_coordinates": _coordinate_steps,
    "dense_correspondence": _correspondence_steps,
}


def _write_converted(path: str, data: np.ndarray, convert: Callable, backend_instance: Any) -> None:
    write_image(path, convert(data), backend_instance)


def eight_bit(fractions: np.ndarray) -> np.ndarray:
    """Map 0..1 to 0..255, as uint8."""
    return (fractions * 255 + 0.5).astype(np.uint8)


def colorize_normals(normals: np.ndarray) -> np.ndarray:
    """Map -1..1 to 0..255, as uint8 (H, W, 4)."""
    return ((normals * 0.5 + 0.5) * 255).astype(np.uint8)


def colorize_distance(distance: np.ndarray, near: float | None = None, far: float | None = None) -> np.ndarray:
    """Return distances (H, W) [m] as uint8 (H, W), on a logarithmic scale: white at `near`, black at `far` and beyond.

    None takes the smallest or the largest finite distance that there is.
    """
    finite = distance[np.isfinite(distance) & (distance > 0)]
    if near is None:
        near = float(finite.min()) if finite.size else 1e-5
    if far is None:
        far = float(finite.max()) if finite.size else 100.0
    # All at one distance, up to the rounding of depths: any range above it gives white.
    far = far if far > near * (1 + 1e-5) else near * 2.0
    # The logarithm of a ratio, so that `near` is exactly white in float32.
    fraction = np.log(np.clip(distance, near, far) / np.float32(near)) / np.log(far / near)
    return (np.clip(1.0 - fraction, 0, 1) * 255).astype(np.uint8)
