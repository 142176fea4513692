"""`carb`: vectors, logging and settings."""

import logging
from collections.abc import Sequence

from usdsdg.compat.carb import dictionary, settings, tokens

__all__ = [
    "ColorRgb", "ColorRgba", "Double2", "Double3", "Double4", "Float2", "Float3", "Float4", "Int2", "Int3", "Int4",
    "Uint2", "Uint3", "Uint4", "dictionary", "log_error", "log_info", "log_verbose", "log_warn", "settings",
    "tokens",
]  # fmt: skip

_log = logging.getLogger("usdsdg.script")


class _Vector(tuple):
    """A vector of `size` numbers of one type, from numbers or from one sequence, with x, y, z, w."""

    size = 0
    number: type[float] | type[int] = float

    def __new__(cls, *values: float | Sequence[float]):
        flat = values[0] if len(values) == 1 and not isinstance(values[0], (int, float)) else values
        # float() and int() raise the TypeError for a sequence among several values.
        numbers = tuple(cls.number(v) for v in flat) or (cls.number(),) * cls.size  # pyright: ignore[reportArgumentType]
        if len(numbers) != cls.size:
            raise TypeError(f"{cls.__name__} takes {cls.size} numbers, got {len(numbers)}")
        return super().__new__(cls, numbers)

    @property
    def x(self) -> float:
        return self[0]

    @property
    def y(self) -> float:
        return self[1]

    @property
    def z(self) -> float:
        return self[2]

    @property
    def w(self) -> float:
        return self[3]


class Float2(_Vector):
    size = 2


class Float3(_Vector):
    size = 3


class Float4(_Vector):
    size = 4


class Double2(_Vector):
    size = 2


class Double3(_Vector):
    size = 3


class Double4(_Vector):
    size = 4


class Int2(_Vector):
    size, number = 2, int


class Int3(_Vector):
    size, number = 3, int


class Int4(_Vector):
    size, number = 4, int


class _Unsigned(_Vector):
    """A vector of whole numbers that are not below 0."""

    number = int

    def __new__(cls, *values: float | Sequence[float]):
        made = super().__new__(cls, *values)
        if min(made, default=0) < 0:
            raise TypeError(f"{cls.__name__} takes numbers that are not below 0, got {tuple(made)}")
        return made


class Uint2(_Unsigned):
    size = 2


class Uint3(_Unsigned):
    size = 3


class Uint4(_Unsigned):
    size = 4


class _Color(_Vector):
    """A color, with r, g, b, a."""

    r, g, b, a = _Vector.x, _Vector.y, _Vector.z, _Vector.w


class ColorRgb(_Color):
    size = 3


class ColorRgba(_Color):
    size = 4


def log_verbose(message: str) -> None:
    _log.debug(message)


def log_info(message: str) -> None:
    _log.info(message)


def log_warn(message: str) -> None:
    _log.warning(message)


def log_error(message: str) -> None:
    _log.error(message)
