"""What a page may ask for. Everything else is refused with one line."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

# Parts of a picture's height or width; a pointer may leave the picture.
Part = Annotated[float, Field(ge=-100.0, le=100.0, allow_inf_nan=False)]
Inside = Annotated[float, Field(ge=0.0, le=1.0)]
Side = Annotated[int, Field(ge=16, le=2048)]


class _Asking(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)


class Shown(_Asking):
    """The page has shown a picture, or has dropped it."""

    do: Literal["shown"]


class Turn(_Asking):
    """Orbit: the pointer moved by parts of the picture's height."""

    do: Literal["turn"]
    by: tuple[Part, Part]


class Move(_Asking):
    """Pan: the pointer moved by parts of the picture's height."""

    do: Literal["move"]
    by: tuple[Part, Part]


class Zoom(_Asking):
    """Multiply the distance to the target."""

    do: Literal["zoom"]
    by: Annotated[float, Field(gt=0.01, lt=100.0)]


class Frame(_Asking):
    """Look at the selected thing, or at everything."""

    do: Literal["frame"]
    what: Literal["all", "selection"]


class Through(_Asking):
    """Look through a camera of the stage, or orbit freely from where it is."""

    do: Literal["through"]
    camera: Annotated[str, Field(max_length=4096)] | None


class Mode(_Asking):
    """Show another kind of picture."""

    do: Literal["mode"]
    name: Annotated[str, Field(max_length=40)]


class Size(_Asking):
    """Make pictures of a size [pixels]."""

    do: Literal["size"]
    width: Side
    height: Side


class Pick(_Asking):
    """Select what is at a place of the picture, as parts of its width and height; None: nothing."""

    do: Literal["pick"]
    at: tuple[Inside, Inside] | None


class Randomize(_Asking):
    """Run the triggers once more."""

    do: Literal["randomize"]
    seed: Annotated[int, Field(ge=0, lt=1 << 53)]


class Simple(_Asking):
    """What needs no more words: physics, and the next frame of a script or job."""

    do: Literal["play", "pause", "step", "reset", "next"]


Asking = Annotated[
    Shown | Turn | Move | Zoom | Frame | Through | Mode | Size | Pick | Randomize | Simple, Field(discriminator="do")
]
_ADAPTER: TypeAdapter[Asking] = TypeAdapter(Asking)


class Misunderstood(ValueError):
    """A message that is none of these."""


def parse(text: str) -> Asking:
    """Return a message as a record.

    Raises:
        Misunderstood: it is none.
    """
    try:
        return _ADAPTER.validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        place = ".".join(map(str, first["loc"]))
        raise Misunderstood(f"not understood: {place or 'message'}: {first['msg']}") from None
