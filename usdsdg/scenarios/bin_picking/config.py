"""Keys of the bin picking job."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from usdsdg.scenarios.config_values import (
    CountRange,
    Length,
    PlannedCount,
    Positive,
    Range,
    Section,
    SomeCount,
    SomeSeconds,
    Text,
)
from usdsdg.scenarios.shared.formats import writer_names
from usdsdg.scenarios.shared.sections import (
    CameraConfig,
    Formats,
    JobConfig,
    Lights,
    Pictures,
    Rendering,
    Skies,
    mounts_of,
)

Folder = Annotated[str, Field(strict=True)]
Tilt = Annotated[float, Field(strict=True, ge=0.0, le=80.0)]
Approximation = Literal["convexHull", "convexDecomposition", "sdf"]


class Bin(Section):
    """The bin. Its floor is at height 0, its middle at the origin."""

    size: tuple[Length, Length, Length] | None = Field(
        default=None,
        description="inner width, depth and height [m], for example [0.4, 0.3, 0.15]; null to suit the parts",
    )
    thickness: Length = Field(default=0.004, description="thickness of its walls [m]")


class Parts(Section):
    """What is dropped into the bin."""

    per_bin: CountRange = Field(default=(12, 30), description="fewest and most parts of a drop, for example [12, 30]")
    classes: Literal["mixed", "one"] = Field(
        default="mixed", description="mixed, or one: all parts of a drop are of one class"
    )
    collider: Approximation = Field(
        default="convexDecomposition",
        description="convexDecomposition, which keeps hollows, or convexHull; sdf becomes the former",
    )
    max_time: SomeSeconds = Field(
        default=6.0, description="simulated seconds until the parts rest, at most; 3600 or less"
    )

    @field_validator("per_bin")
    @classmethod
    def _some(cls, counts: tuple[int, int]) -> tuple[int, int]:
        if counts[0] < 1:
            raise ValueError(f"{list(counts)} leaves bins empty; expected at least [1, 1]")
        return counts


class BinCameras(CameraConfig):
    """The cameras above the bin: of one lens, or a calibrated rig."""

    count: SomeCount = Field(default=3, description="number of cameras, 1 or more; a rig has its own")
    tilt: tuple[Tilt, Tilt] = Field(
        default=(0.0, 40.0), description="smallest and largest angle from the vertical [degrees], for example [0, 40]"
    )
    bin_in_image: Range = Field(
        default=(0.9, 1.6), description="size of the bin as a fraction of the picture's, for example [0.9, 1.6]"
    )


class BinPickingConfig(JobConfig):
    """All keys of the bin picking job."""

    other_names = {
        "num_frames": "drops, and frames_per_drop for each camera",
        "num_cameras": "cameras.count",
        "camera": "cameras",
        "objects": "parts",
        "backgrounds": "table and skies",
    }

    meshes: Folder = Field(
        default="", validate_default=True, description="a folder of meshes or USD files; empty for parts made by code"
    )
    output_dir: Text = Field(default="_out_bin_picking", description="the folder of the dataset")
    rendering: Rendering = Field(default=Rendering(samples=12), description="a mapping with samples and path_tracing")
    formats: Formats = Field(
        default={"bop": {}},
        validate_default=True,
        description="formats to write with their options, such as {bop: {}, coco: {}}",
    )
    splits: dict[Text, Positive] = Field(
        default={"train_pbr": 0.8, "val_pbr": 0.2},
        description="shares of the parts, for example {train_pbr: 0.8, val_pbr: 0.2}; drops are not divided",
    )
    drops: PlannedCount = Field(default=5, description="number of fillings of the bin, 1 to 1,000,000")
    frames_per_drop: PlannedCount = Field(
        default=4, description="pictures of each camera for a filling, from other places in other light; 1 or more"
    )
    bin: Bin = Field(default=Bin(), description="a mapping with size and thickness")
    parts: Parts = Field(default=Parts(), description="a mapping with per_bin, classes, collider, max_time")
    cameras: BinCameras = Field(
        default=BinCameras(),
        description="a mapping with count, tilt, bin_in_image, calibration, undistorted, field_of_view",
    )
    table: Pictures = Field(
        default="", description="a folder of pictures for the table around the bin; empty for patterns made by code"
    )
    skies: Skies = Field(
        default="/NVIDIA/Assets/Skies/Indoor",
        validate_default=True,
        description="a folder of equirectangular pictures, which light the bin",
    )
    lights: Lights = Field(default=Lights(), description="a mapping with sky, lamps, lamp_count")

    @model_validator(mode="after")
    def _fits_the_format(self) -> BinPickingConfig:
        bent = [each.name for each in mounts_of(self.cameras) if not each.calibration.is_straight]
        if bent and any(writer_names().get(name.lower(), name) == "BopWriter" for name in self.formats):
            raise ValueError(
                f"cameras.calibration: {', '.join(bent)} has a distorted lens, and BOP has pinholes only; expected "
                "cameras.undistorted: true, which renders pictures after the distortion has been removed"
            )
        if self.cameras.tilt[0] > self.cameras.tilt[1]:
            raise ValueError(f"cameras.tilt: {list(self.cameras.tilt)}; expected the smaller number first")
        return self

    @property
    def num_frames(self) -> int:
        """Number of frames of each camera."""
        return self.drops * self.frames_per_drop

    @property
    def frames_per_episode(self) -> int:
        """Number of frames of each camera on one stage: each drop has a new one."""
        return self.frames_per_drop
