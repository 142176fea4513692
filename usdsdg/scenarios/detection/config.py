"""Keys of the detection job."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from usdsdg.scenarios.config_values import CountRange, PlannedCount, Positive, Range, Section, Shape, Text
from usdsdg.scenarios.shared.mesh_folder import files_by_label
from usdsdg.scenarios.shared.sections import (
    CameraConfig,
    Formats,
    Fraction,
    JobConfig,
    Lights,
    Pictures,
    Skies,
    as_value_error,
    mounts_of,
)

Folder = Annotated[str, Field(strict=True)]


class Objects(Section):
    """The labeled objects of a picture."""

    per_image: CountRange = Field(
        default=(1, 6), description="fewest and most objects in a picture, for example [1, 6]"
    )
    size_in_image: Range = Field(
        default=(0.2, 0.7),
        description="smallest and largest size as a fraction of the height, such as [0.2, 0.7]",
    )
    class_balance: Literal["even"] | dict[Text, Positive] = Field(
        default="even", description="even, or shares by class such as {mug: 2, bolt: 1}"
    )

    @field_validator("per_image")
    @classmethod
    def _some(cls, counts: tuple[int, int]) -> tuple[int, int]:
        if counts[1] < 1:
            raise ValueError(f"{list(counts)} has no objects at all; expected at least [0, 1]")
        return counts


class Control(Section):
    """How many objects are hidden or cut off in part, and how far."""

    share: Fraction = Field(default=0.3, description="share of the objects, 0 to 1")
    most: Fraction = Field(default=0.6, description="the most of one object that is hidden or cut off, 0 to 1")


class Distractors(Section):
    """What is in front of, behind and beside the objects, without labels."""

    per_image: CountRange = Field(
        default=(4, 12), description="fewest and most distractors in a picture, for example [4, 12]"
    )
    shapes: list[Shape] = Field(
        default=["capsule", "cone", "cylinder", "sphere", "cube"],
        description="any of capsule, cone, cylinder, sphere, cube",
    )
    meshes: Folder = Field(default="", description="a folder of meshes or USD files; empty for none")
    size_in_image: Range = Field(
        default=(0.15, 0.6), description="smallest and largest size as a fraction of the height, such as [0.15, 0.6]"
    )

    @field_validator("meshes")
    @classmethod
    def _has_meshes(cls, folder: str) -> str:
        if folder:
            as_value_error(files_by_label, folder)
        return folder


class Backgrounds(Section):
    """What is behind everything."""

    pictures: Pictures = Field(default="", description="a folder of pictures; empty for patterns made by code")
    skies: Skies = Field(
        default="/NVIDIA/Assets/Skies/Indoor",
        description="a folder of equirectangular pictures, such as .hdr files",
    )
    share_of_pictures: Fraction = Field(default=0.6, description="share of the frames, 0 to 1; the others show a sky")


class DetectionConfig(JobConfig):
    """All keys of the detection job."""

    other_names = {"drops": "num_frames", "cameras": "camera", "parts": "objects"}

    num_frames: PlannedCount = Field(default=20, description="number of pictures, 1 to 1,000,000")
    meshes: Text = Field(
        default="/Isaac/Props/YCB/Axis_Aligned",
        validate_default=True,
        description="a folder of meshes or USD files, one object each",
    )
    output_dir: Text = Field(default="_out_detection", description="the folder of the dataset")
    formats: Formats = Field(
        default={"yolo": {}, "coco": {}},
        validate_default=True,
        description="formats to write with their options, such as {yolo: {}, coco: {}}",
    )
    splits: dict[Text, Positive] = Field(
        default={"train": 0.8, "val": 0.2}, description="shares of the parts, for example {train: 0.8, val: 0.2}"
    )
    camera: CameraConfig = Field(
        default=CameraConfig(), description="a mapping with calibration, undistorted, field_of_view"
    )
    objects: Objects = Field(default=Objects(), description="a mapping with per_image, size_in_image, class_balance")
    occlusion: Control = Field(default=Control(), description="a mapping with share and most")
    truncation: Control = Field(default=Control(share=0.15, most=0.5), description="a mapping with share and most")
    distractors: Distractors = Field(
        default=Distractors(), description="a mapping with per_image, shapes, meshes, size_in_image"
    )
    backgrounds: Backgrounds = Field(
        default=Backgrounds(), description="a mapping with pictures, skies, share_of_pictures"
    )
    lights: Lights = Field(default=Lights(), description="a mapping with sky, lamps, lamp_count")

    @field_validator("camera")
    @classmethod
    def _is_one(cls, camera: CameraConfig) -> CameraConfig:
        mounts = mounts_of(camera)
        if len(mounts) > 1:
            choices = ", ".join(f"{camera.calibration}#{each.name}" for each in mounts)
            raise ValueError(f"camera.calibration has {len(mounts)} cameras; this job has one: choose {choices}")
        return camera

    @model_validator(mode="after")
    def _balances_classes(self) -> DetectionConfig:
        balance = self.objects.class_balance
        if isinstance(balance, dict):
            known = list(self.files())
            if unknown := [name for name in balance if name.lower() not in known]:
                raise ValueError(
                    f"objects.class_balance: no class {', '.join(unknown)}; the meshes have {', '.join(known[:20])}"
                )
            if missing := [name for name in known if name not in {each.lower() for each in balance}]:
                raise ValueError(
                    f"objects.class_balance: no share of {', '.join(missing)}; expected one for each class"
                )
        if not (self.distractors.shapes or self.distractors.meshes) and self.distractors.per_image[1]:
            raise ValueError("distractors: neither shapes nor meshes; expected some, or per_image: [0, 0]")
        return self
