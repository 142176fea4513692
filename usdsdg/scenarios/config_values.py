"""Types of values in configurations: numbers with bounds, ranges, texts."""

from typing import Annotated, ClassVar, Literal, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from usdsdg.arguments.values import MOST_PRIMS, TOO_MANY_PRIMS

# Numbers are strict: "3" and true are not numbers.
# Shares, of which the sum must be a number, too.
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=1e12)]
# Lengths of a scene, and times: physics and its matrices end at numbers that no scene has.
Length = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=1e6)]
Seconds = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=3600)]
SomeSeconds = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=3600)]
LengthOrNone = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=1e6)]


def _bearable(count: int) -> int:
    if count > MOST_PRIMS:
        raise ValueError(f"{count}: {TOO_MANY_PRIMS}")
    return count


Count = Annotated[int, Field(strict=True, ge=0), AfterValidator(_bearable)]
# Numbers of frames: a billion takes a year at 30 a second.
FrameCount = Annotated[int, Field(strict=True, ge=0, le=1_000_000_000)]
Seed = Annotated[int, Field(strict=True, ge=0, lt=1 << 63)]
# Of frames and drops that are all planned before the first one: a million takes some 40 seconds and 1 GB of memory.
PlannedCount = Annotated[int, Field(strict=True, ge=1, le=1_000_000)]
SomeCount = Annotated[Count, Field(ge=1)]
# Of a pixel: with fewer of them no noise is left that 8 bits show.
Samples = Annotated[int, Field(strict=True, ge=1, le=1 << 20)]
AtLeastOne = Annotated[int, Field(strict=True, ge=1)]
Text = Annotated[str, Field(strict=True, min_length=1)]
Flag = Annotated[bool, Field(strict=True)]
Shape = Literal["capsule", "cone", "cylinder", "sphere", "cube"]


_Pair = TypeVar("_Pair", tuple[float, float], tuple[int, int])


def _ordered(values: _Pair) -> _Pair:
    if values[0] > values[1]:
        raise ValueError(f"{list(values)} is the wrong way round; expected the smaller number first")
    return values


# Of lengths, or of factors: a million times the size, or the brightness, is as far from any scene.
Range = Annotated[tuple[Length, Length], AfterValidator(_ordered)]


def _of_one_scene(values: tuple[int, int]) -> tuple[int, int]:
    if values[1] > MOST_IN_SCENE:
        raise ValueError(f"{list(values)}: at most {MOST_IN_SCENE:,} are placed in one picture or bin; expected fewer")
    return values


# What is placed in one picture or bin, each against all others.
MOST_IN_SCENE = 10_000
CountRange = Annotated[tuple[Count, Count], AfterValidator(_ordered), AfterValidator(_of_one_scene)]


class Section(BaseModel):
    """A mapping of a configuration: unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True)
    # Keys that users of other jobs may write here, with what does the same.
    other_names: ClassVar[dict[str, str]] = {}
