"""Keys that all jobs have, and those of a camera."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, Field, ValidationInfo, field_validator, model_validator

from usdsdg import demo
from usdsdg.calibration.files import read_calibration, read_rig
from usdsdg.calibration.rig import Mount
from usdsdg.errors import UsdsdgError
from usdsdg.scenarios.config_values import AtLeastOne, CountRange, Flag, Positive, Range, Samples, Section, Seed, Text
from usdsdg.scenarios.shared.formats import format_problems
from usdsdg.scenarios.shared.mesh_folder import files_by_label
from usdsdg.scenarios.shared.pictures import pictures_in, skies_in
from usdsdg.session.render_products import size_problem
from usdsdg.writers.formats.splits import name_problem

Fraction = Annotated[float, Field(strict=True, ge=0.0, le=1.0)]
Angle = Annotated[float, Field(strict=True, ge=0.1, lt=170.0)]
Formats = dict[Text, dict[Text, Any] | None]
Unit = Literal["auto", "m", "cm", "mm", "inch", "foot"]


def _checked_pictures(folder: str) -> str:
    if folder:
        as_value_error(pictures_in, folder)
    return folder


def _checked_skies(folder: str) -> str:
    as_value_error(skies_in, folder)
    return folder


def as_value_error(function: Any, *arguments: Any) -> Any:
    """Call a function of our own, with its errors as those of a validator, which are reported with all others."""
    try:
        return function(*arguments)
    except UsdsdgError as error:
        raise ValueError(str(error)) from error


# A folder of pictures, or "" for those made by code; a folder of equirectangular pictures.
Pictures = Annotated[str, Field(strict=True), AfterValidator(_checked_pictures)]
Skies = Annotated[str, Field(strict=True, min_length=1), AfterValidator(_checked_skies)]


class Rendering(Section):
    """How pictures are rendered."""

    samples: Annotated[Samples, Field(ge=4)] = Field(
        default=8, description="samples per pixel, 4 or more; more of them give less noise"
    )
    path_tracing: Flag = Field(
        default=False, description="true: many bounces of light, and 128 samples or more; false: the fast mode"
    )


class Lights(Section):
    """How bright a white surface is, as fractions of white in the picture."""

    sky: Range = Field(
        default=(0.25, 0.7),
        description="brightness of a white surface under the sky, as fractions of white, such as [0.25, 0.7]",
    )
    lamps: Range = Field(
        default=(0.2, 0.9),
        description="brightness of it under lamps, such as [0.2, 0.9]; lamp_count: [0, 0] for no lamp",
    )
    lamp_count: CountRange = Field(default=(0, 2), description="fewest and most lamps, for example [0, 2]")


class JobConfig(Section):
    """Keys of every job. Lengths are in meters."""

    job: Text = Field(description="detection or bin_picking")
    meshes: Text = Field(description="a folder of meshes or USD files, one object each")
    mesh_unit: Unit = Field(default="auto", description="auto, m, cm, mm, inch or foot")
    labels: dict[Text, Annotated[str, Field(strict=True)]] = Field(
        default={}, description="classes by the names of meshes, for example {mug_2: mug}; '' leaves a mesh out"
    )
    output_dir: Text = Field(description="the folder of the dataset, relative to the working directory")
    formats: Formats = Field(
        description="formats to write with their options, for example {yolo: {task: segment}, coco: {}}"
    )
    splits: dict[Text, Positive] = Field(description="shares of the parts, for example {train: 0.8, val: 0.2}")
    min_visibility: Fraction = Field(
        default=0.0, description="smallest visible fraction of an object that is labeled, 0 to 1"
    )
    min_pixels: AtLeastOne = Field(
        default=1, description="fewest visible pixels of an object that is labeled, 1 or more"
    )
    resolution: tuple[AtLeastOne, AtLeastOne] | None = Field(
        default=None,
        description="width and height in pixels, as in [320, 240]; null for the calibration's, or 640 x 480",
    )
    rendering: Rendering = Field(default=Rendering(), description="a mapping with samples and path_tracing")
    seed: Seed = Field(default=0, description="a whole number, 0 or more; the same seed gives the same dataset")

    @field_validator("resolution")
    @classmethod
    def _can_be_made(cls, resolution: tuple[int, int] | None, info: ValidationInfo) -> tuple[int, int] | None:
        if resolution and (problem := size_problem(*resolution)):
            raise ValueError(problem)
        least = info.data.get("min_pixels", 1)
        if resolution and least > resolution[0] * resolution[1]:
            raise ValueError(f"{list(resolution)} has fewer pixels than min_pixels, {least}: nothing would be labeled")
        return resolution

    @field_validator("splits")
    @classmethod
    def _are_names(cls, splits: dict[str, float]) -> dict[str, float]:
        if problem := name_problem(splits):
            raise ValueError(problem)
        return splits

    @field_validator("formats")
    @classmethod
    def _are_written(cls, formats: dict[str, Any]) -> dict[str, Any]:
        if problems := format_problems(formats):
            raise ValueError("; ".join(problems))
        return {name: dict(options or {}) for name, options in formats.items()}

    @field_validator("labels")
    @classmethod
    def _are_meshes(cls, labels: dict[str, str], info: ValidationInfo) -> dict[str, str]:
        if "meshes" in info.data:
            as_value_error(files_by_label, mesh_folder(info.data["meshes"]), labels)
        return labels

    @property
    def frames_per_episode(self) -> int:
        """Number of frames after which a new stage is built; 0: all frames have one."""
        return 0

    @field_validator("meshes")
    @classmethod
    def _has_meshes(cls, folder: str) -> str:
        as_value_error(files_by_label, mesh_folder(folder))
        return folder

    def files(self) -> dict[str, list[str]]:
        """Return the mesh files by class."""
        return files_by_label(mesh_folder(self.meshes), self.labels)


class CameraConfig(Section):
    """The lens of the cameras: a calibration, or a field of view."""

    calibration: Annotated[str, Field(strict=True)] = Field(
        default="", description="YAML file of OpenCV, ROS or Kalibr; with several cameras, a rig; empty for none"
    )
    undistorted: Flag = Field(
        default=False, description="true: pictures after the distortion of the calibration has been removed"
    )
    field_of_view: Angle = Field(default=55.0, description="degrees across, without a calibration; 0.1 to 170")

    @model_validator(mode="after")
    def _can_be_read(self) -> CameraConfig:
        if self.calibration:
            as_value_error(mounts_of, self)
        elif self.undistorted:
            raise ValueError("camera.undistorted is true without a calibration; expected one in camera.calibration")
        return self


def mesh_folder(folder: str) -> str:
    """Return a folder of meshes; that of parts made by code for "".

    Raises:
        AssetError: those cannot be written.
    """
    return folder or demo.machine_parts()


def mounts_of(camera: CameraConfig) -> list[Mount]:
    """Return the calibrated cameras; of `file#name` that one, at the place of the rig. [] without a calibration.

    Raises:
        ConfigError: the calibration cannot be read.
    """
    if not camera.calibration:
        return []
    file, _, name = camera.calibration.partition("#")
    mounts = list(read_rig(file).mounts)
    if name:
        mounts = [only_mount(camera.calibration)]
    if camera.undistorted:
        mounts = [Mount(each.name, each.calibration.undistorted(), each.pose) for each in mounts]
    return mounts


def only_mount(path: str) -> Mount:
    """Return one calibrated camera at the place of the rig."""
    return Mount(Path(path).name.partition("#")[2] or "camera", read_calibration(path), np.eye(4))
