"""DOPEWriter: one image and one JSON of poses per frame, as DOPE's training reads them."""

import os
from collections.abc import Iterable, Mapping
from functools import partial
from typing import Any

import numpy as np

from usdsdg.annotators import named_annotators
from usdsdg.annotators.annotator import Annotator
from usdsdg.errors import WriterError
from usdsdg.writers.backends.backend import BaseBackend
from usdsdg.writers.backends.group import make_backend
from usdsdg.writers.base import Writer
from usdsdg.writers.files import checked_image_format, write_image, write_json
from usdsdg.writers.formats.dope.dope_objects import camera_data, exact_objects, node_objects
from usdsdg.writers.formats.pose.left_out import LeavesFramesOut, LeftOut
from usdsdg.writers.formats.pose.pose_camera import register_pose_camera
from usdsdg.writers.options import typed
from usdsdg.writers.registry import get

RGB, POSES, BOXES, CAMERA = "rgb", "dope", "bounding_box_3d", "camera_params"
_BUCKET_LETTERS = range(3, 64)


class DOPEWriter(LeavesFramesOut, Writer):
    """Writes `NNNNNN.png` and `NNNNNN.json` of frames in which a labeled object is visible.

    The JSON has an object for each labeled prim in view: class, visibility, location, quaternion_wxyz, and
    projected_cuboid, its box in DOPE's order. The numbers are those of Isaac Sim: docs/compatibility.md has what is
    unexpected of them, and `exact=True` gives others. Several render products have folders of their own, with the
    images in `rgb` below, or with `exact` beside the JSON.
    """

    version = "0.0.1"
    data_structure = "renderProduct"
    shares_arrays = True
    kept = ("_frame_id", "_counts")

    @typed
    def __init__(
        self,
        output_dir: str | os.PathLike,
        class_name_to_index_map: Mapping,
        semantic_types: list[str] | None = None,
        image_output_format: str = "png",
        use_s3: bool = False,
        bucket_name: str | None = "",
        endpoint_url: str | None = "",
        s3_region: str | None = "us-east-1",
        *,
        backend: BaseBackend | None = None,
        exact: bool = False,
    ) -> None:
        """
        class_name_to_index_map: accepted; the files have no indices.
        semantic_types: types of labels; default ["class"].
        use_s3: write to the bucket `bucket_name`, below `output_dir` as a prefix; endpoint_url, s3_region: see
            `S3Backend`.
        exact: locations in centimeters whatever the stage's unit, keypoints of any lens with the center of the box,
            x right, y down, z ahead, and the camera's intrinsics.

        Raises:
            WriterError: an option has an invalid value, or there is nowhere to write.
            OutputNotWritable: output_dir or the bucket cannot be written to.
            Unsupported: a bucket without obstore.
        """
        self._image_format = checked_image_format(image_output_format)
        if use_s3 and len(bucket_name or "") not in _BUCKET_LETTERS:
            raise WriterError(f"DOPEWriter: bucket_name is {bucket_name!r}; names of buckets have 3 to 63 letters.")
        self.backend = make_backend(
            "DOPEWriter", output_dir, backend, bucket=bucket_name if use_s3 else None,
            region=s3_region or None, endpoint_url=endpoint_url or None,
        )  # fmt: skip
        self._exact = exact
        self._frame_id = 0
        self._left_out = LeftOut()
        labels = {"semanticTypes": semantic_types or ["class"]}
        poses = [named_annotators.get(BOXES, labels), named_annotators.get(CAMERA)]
        self.annotators = [named_annotators.get(RGB), *(poses if exact else [named_annotators.get(POSES, labels)])]

    @staticmethod
    def register_pose_annotator(config_data: Mapping[str, Any]) -> None:
        """Set what the annotator `dope` computes with, for the writers that are initialized from now on.

        config_data: WIDTH and HEIGHT of the pictures [pixels], and CAMERA_ROTATION, the Euler angles [degrees] of the
            rendering camera in the camera frame of the poses. Without this call it is (180, 0, 0): x right, y down,
            z ahead.
        """
        register_pose_camera(POSES, config_data, width="width", height="height")

    @staticmethod
    def setup_writer(config_data: Mapping[str, Any], writer_config: Mapping[str, Any]) -> Writer:
        """Return an initialized writer.

        config_data: CLASS_NAME_TO_INDEX. writer_config: output_folder, use_s3, bucket_name, endpoint_url.
        """
        options = {
            "output_dir": writer_config["output_folder"],
            "class_name_to_index_map": config_data["CLASS_NAME_TO_INDEX"],
            **{name: writer_config[name] for name in ("use_s3", "bucket_name", "endpoint_url")},
        }
        return get("DOPEWriter", init_params=options)

    def annotators_to_skip(self) -> list[Annotator]:
        return [each for each in self.annotators if each.get_name() != RGB]

    def skip(self, data: dict[str, Any]) -> None:
        described = [self._described(seen) for seen in data["renderProducts"].values()]
        self._frame_id += self._left_out.note(_shows_any(described))

    def write(self, data: dict[str, Any]) -> None:
        described = {product: self._described(seen) for product, seen in data["renderProducts"].items()}
        if not self._left_out.note(_shows_any(described.values())):
            return
        several = max(len(self.render_products), len(described)) > 1
        assert self.backend is not None
        for product, values in described.items():
            folder = f"{product}/" if several else ""
            # Isaac Sim's place, in which DOPE's training does not look for pictures.
            apart = "rgb/" if several and not self._exact else ""
            image = f"{folder}{apart}{self._frame_id:06d}.{self._image_format}"
            rgb = np.asarray(data["renderProducts"][product][RGB]["data"])
            # JSON last, so that a frame with JSON has its image.
            self.backend.schedule_together(
                [
                    partial(write_image, path=image, data=rgb),
                    partial(write_json, path=f"{folder}{self._frame_id:06d}.json", data=values, indent=2),
                ]
            )
        self._frame_id += 1

    def on_final_frame(self) -> None:
        """Warn if no frame had an object, so that nothing was written."""
        self._left_out.warn("DOPEWriter")

    def _described(self, seen: Mapping[str, Any]) -> dict[str, Any]:
        if not self._exact:
            return {"camera_data": {}, "objects": node_objects(seen[POSES])}
        return {"camera_data": camera_data(seen[CAMERA]), "objects": exact_objects(seen[BOXES], seen[CAMERA])}


def _shows_any(described: Iterable[Mapping[str, Any]]) -> bool:
    """Return whether any object of some pictures is visible."""
    return any(each["visibility"] > 0.0 for values in described for each in values["objects"])
