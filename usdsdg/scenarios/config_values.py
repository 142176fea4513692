"""Types of values in configurations: numbers with bounds, ranges, texts."""

from typing import Annotated, Literal, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

# Numbers are strict: "3" and true are not numbers.
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0)]
NotNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0)]
Count = Annotated[int, Field(strict=True, ge=0)]
AtLeastOne = Annotated[int, Field(strict=True, ge=1)]
Text = Annotated[str, Field(strict=True, min_length=1)]
Flag = Annotated[bool, Field(strict=True)]
Shape = Literal["capsule", "cone", "cylinder", "sphere", "cube"]


_Pair = TypeVar("_Pair", tuple[float, float], tuple[int, int])


def _ordered(values: _Pair) -> _Pair:
    if values[0] > values[1]:
        raise ValueError(f"{list(values)} is the wrong way round; expected the smaller number first")
    return values


Range = Annotated[tuple[Positive, Positive], AfterValidator(_ordered)]
CountRange = Annotated[tuple[Count, Count], AfterValidator(_ordered)]


class Section(BaseModel):
    """A mapping of a configuration: unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True)
