"""Configuration of the object-based scenario: the keys of Isaac Sim's example, and two of ours.

The default of a key is that of Isaac Sim's example.
"""

from functools import partial
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationInfo, field_validator

from usdsdg.errors import ConfigError
from usdsdg.scenarios.config_values import (
    AtLeastOne,
    Count,
    Flag,
    FrameCount,
    Length,
    LengthOrNone,
    Range,
    Samples,
    Seconds,
    Section,
    Seed,
    Shape,
    SomeSeconds,
    Text,
)
from usdsdg.scenarios.object_based.camera_properties import checked_camera_properties
from usdsdg.scenarios.shared.sections import as_value_error
from usdsdg.session.render_products import size_problem
from usdsdg.stage.semantics.semantic_classes import read_semantic_classes
from usdsdg.writers.base import Writer
from usdsdg.writers.options import check_names
from usdsdg.writers.registry import registered


class LaunchConfig(Section):
    """Launch options of Isaac Sim, of which only the renderer has an effect."""

    renderer: Literal["RayTracedLighting", "RaytracedLighting", "PathTracing"] = Field(
        default="RayTracedLighting", description="RayTracedLighting or PathTracing"
    )
    headless: Flag = Field(default=False, description="true or false; without effect, since there is never a window")


class LabeledAsset(Section):
    """One kind of labeled object."""

    url: Text = Field(description="path of a USD file under the assets root, for example /Isaac/Props/YCB/…/x.usd")
    label: Text = Field("unknown", description="the class of its label")
    count: Count = Field(1, description="number of objects, 0 or more")
    floating: Flag = Field(False, description="true: no gravity; false: falls")
    scale_min_max: Range | None = Field(None, description="smallest and largest scale, for example [0.85, 1.25]")
    randomize_scale: Range | None = Field(
        None, description="the same as scale_min_max, under the name that the code of Isaac Sim's example reads"
    )

    @property
    def scale_range(self) -> tuple[float, float]:
        """The smallest and the largest scale, under either name; 1 where neither is given."""
        return self.randomize_scale or self.scale_min_max or (1.0, 1.0)

    @field_validator("randomize_scale")
    @classmethod
    def _one_name(cls, scale: tuple[float, float] | None, info: ValidationInfo) -> tuple[float, float] | None:
        other = info.data.get("scale_min_max")
        if scale and other and scale != other:
            raise ValueError(
                f"{list(scale)} differs from scale_min_max, which means the same; expected only one of them"
            )
        return scale


class PathTracing(Section):
    """Options of the frames that are path traced with motion blur instead of rendered in the fast mode."""

    every: Count = Field(default=5, description="period in frames: 5 is frames 0, 5, 10, …; 0 is none")
    spp: Samples = Field(default=128, description="samples per pixel, 1 or more")
    sub_frames: Samples = Field(default=8, description="sub-frames of one exposure, 1 or more")
    duration: SomeSeconds = Field(default=0.025, description="exposure time in seconds, 3600 or less")
    denoise: Flag = Field(default=False, description="true or false")


class ObjectBasedConfig(Section):
    """All options of the object-based scenario. Lengths are in meters, times in seconds."""

    other_names = {
        "output_dir": "writer_kwargs.output_dir",
        "formats": "writer_type and writer_kwargs, such as YoloWriter and {output_dir: dataset}",
        "splits": "writer_kwargs.splits, of writers that have it",
        "meshes": "labeled_assets_and_properties, a list such as [{url: mug.obj, label: mug, count: 3}]",
        "field_of_view": "camera_properties_kwargs, such as {focalLength: 24, horizontalAperture: 20.955}",
        "rendering": "launch_config.renderer and path_tracing",
    }

    launch_config: LaunchConfig = Field(LaunchConfig(), description="a mapping with renderer and headless")
    env_url: Annotated[str, Field(strict=True)] = Field("", description="path of a USD stage, or empty for none")
    working_area_size: tuple[Length, Length, Length] = Field(
        (3, 3, 3), description="width, depth and height [m], for example [5, 5, 3]"
    )
    rt_subframes: Annotated[int, Field(strict=True, ge=-1, le=1 << 20)] = Field(
        -1, description="sub-frames of the fast mode; -1 takes the default"
    )
    num_frames: FrameCount = Field(10, description="number of frames to capture, 0 or more")
    frames_per_episode: FrameCount = Field(
        0, description="frames until a new scene is built from draws of its own; 0: one scene for all frames"
    )
    num_cameras: Count = Field(1, description="number of cameras that capture each frame, 0 or more")
    camera_collider_radius: LengthOrNone = Field(0.0, description="radius [m] kept free around cameras; 0 for none")
    disable_render_products_between_captures: Flag = Field(True, description="true or false")
    simulation_duration_between_captures: Seconds = Field(0.025, description="seconds, 0 to 3600")
    settle: Flag = Field(False, description="true or false: whether all come to rest before the first frame")
    resolution: tuple[AtLeastOne, AtLeastOne] = Field(
        (640, 480), description="width and height in pixels, as in [640, 480]"
    )
    camera_properties_kwargs: dict[Text, Any] = Field({}, description="USD camera attributes, such as focalLength: 24")
    camera_look_at_target_offset: LengthOrNone = Field(0.2, description="meters, 0 or more")
    camera_distance_to_target_min_max: Range = Field(
        (0.1, 0.5), description="nearest and farthest distance [m], for example [0.25, 0.75]"
    )
    camera_aim_again: Flag = Field(
        False, description="true or false: whether cameras are aimed at what they show before every frame"
    )
    writer_type: Text | None = Field(None, description="name of a writer, such as PoseWriter or BasicWriter")
    writer_kwargs: dict[Text, Any] = Field({}, description="arguments of the writer, such as output_dir")
    labeled_assets_and_properties: list[LabeledAsset] = Field(
        [], validate_default=True, description="a list of mappings with url, label, count, floating and scale_min_max"
    )
    shape_distractors_types: list[Shape] = Field(
        ["capsule", "cone", "cylinder", "sphere", "cube"], description="any of capsule, cone, cylinder, sphere, cube"
    )
    shape_distractors_scale_min_max: Range = Field(
        (0.02, 0.2), description="smallest and largest scale, for example [0.015, 0.15]"
    )
    shape_distractors_num: Count = Field(350, description="number of objects, 0 or more")
    mesh_distractors_urls: list[Text] = Field([], description="a list of paths of USD files under the assets root")
    mesh_distractors_scale_min_max: Range = Field(
        (0.1, 2.0), description="smallest and largest scale, for example [0.35, 1.35]"
    )
    mesh_distractors_num: Count = Field(10, description="number of objects, 0 or more")
    seed: Seed = Field(0, description="a whole number, 0 or more; the same seed gives the same dataset")
    semantic_classes: list[Any] | dict[str, Any] | Text | None = Field(
        None, description="names of classes, ids by name, or a class file; the classes of the dataset, in this order"
    )
    path_tracing: PathTracing = Field(PathTracing(), description="a mapping with every, spp, sub_frames, duration")

    @property
    def mesh_distractors_wanted(self) -> int:
        """Number of mesh distractors; 0 where there are no URLs, whatever the default number."""
        return self.mesh_distractors_num if self.mesh_distractors_urls else 0

    @property
    def shape_distractors_wanted(self) -> int:
        """Number of shape distractors; 0 where no types are listed."""
        return self.shape_distractors_num if self.shape_distractors_types else 0

    @field_validator("resolution")
    @classmethod
    def _can_be_made(cls, resolution: tuple[int, int]) -> tuple[int, int]:
        if problem := size_problem(*resolution):
            raise ValueError(problem)
        return resolution

    @field_validator("writer_type")
    @classmethod
    def _is_a_writer(cls, name: str | None) -> str | None:
        if name is not None:
            as_value_error(registered.get, name)
        return name

    @field_validator("writer_kwargs")
    @classmethod
    def _known_to_the_writer(cls, options: dict[str, Any], info: ValidationInfo) -> dict[str, Any]:
        kind = registered.get(info.data["writer_type"]) if info.data.get("writer_type") else None
        if kind is not None and kind.initialize is Writer.initialize:  # others take what they like
            as_value_error(partial(check_names, place="in writer_kwargs"), kind.__name__, kind.__init__, options)
        return options

    @field_validator("camera_properties_kwargs")
    @classmethod
    def _known_to_cameras(cls, properties: dict[str, Any]) -> dict[str, Any]:
        return checked_camera_properties(properties)

    @field_validator("semantic_classes")
    @classmethod
    def _are_classes(cls, given: Any) -> Any:
        try:
            read_semantic_classes(given)
        except ConfigError as error:
            raise ValueError(str(error).removeprefix("semantic_classes: ").removeprefix("semantic_classes ")) from error
        return given

    @field_validator("shape_distractors_num", "mesh_distractors_num")
    @classmethod
    def _has_sources(cls, number: int, info: ValidationInfo) -> int:
        source = "shape_distractors_types" if info.field_name == "shape_distractors_num" else "mesh_distractors_urls"
        if number and info.data.get(source) == []:
            raise ValueError(
                f"asks for {number}, but {source} lists nothing to choose from; expected 0 here or entries there"
            )
        return number

    @field_validator("labeled_assets_and_properties")
    @classmethod
    def _has_targets(cls, assets: list[LabeledAsset], info: ValidationInfo) -> list[LabeledAsset]:
        if info.data.get("num_cameras") and info.data.get("num_frames") and not any(asset.count for asset in assets):
            raise ValueError("lists no object, but cameras need one to look at; expected at least one with count > 0")
        return assets
