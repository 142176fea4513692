"""The time code at which attributes are read, and what varies with it.

One update of the renderer, or of the physics, reads a stage at one time code. Dozens of small readers would only hand
it on to the next, so they take it from this context.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from itertools import repeat
from typing import Any

from pxr import Tf, Usd, UsdGeom

_DEFAULT = Usd.TimeCode.Default()
_time = ContextVar("time code", default=_DEFAULT)
# By value, of which a comparison takes a tenth of the time.
_SAMPLED = {
    source.value
    for source in (Usd.ResolveInfoSourceTimeSamples, Usd.ResolveInfoSourceValueClips, Usd.ResolveInfoSourceSpline)
}

# Times are sums of steps, such as 1/24 s, and codes are their products with a rate: together they are off by this much
# at most, and codes of samples have fewer decimals.
_ROUNDING, _DECIMALS = 1e-7, 6


def time_code_at(seconds: float, stage: Usd.Stage) -> Usd.TimeCode:
    """Return the time code of a stage at a time, that of a sample where only rounding keeps the two apart.

    Held values, such as those of visibility and labels, would be those of the sample before.
    """
    code = seconds * stage.GetTimeCodesPerSecond()
    near = round(code, _DECIMALS)
    return Usd.TimeCode(near if abs(code - near) < _ROUNDING else code)


@contextmanager
def time_context(time: Usd.TimeCode) -> Iterator[None]:
    """Inside, `current_value` reads at `time`."""
    token = _time.set(time)
    try:
        yield
    finally:
        _time.reset(token)


def current_time() -> Usd.TimeCode:
    """Return the time code of the context; outside of one, the default time."""
    return _time.get()


def current_value(attribute: Usd.Attribute) -> Any:
    """Return the attribute's value at the time code of the context; outside of one, at the default time."""
    return attribute.Get(_time.get())


def current_values(attributes: Sequence[Usd.Attribute]) -> list[Any]:
    """Return `current_value` of many attributes; raises as `values_at`."""
    return values_at(attributes, current_time())


def values_at(attributes: Sequence[Usd.Attribute], time: Usd.TimeCode) -> list[Any]:
    """Return the values of many attributes, None for those without one.

    The method is not looked up on the attributes, which takes pxr longer than to read the value.

    Raises:
        RuntimeError: the prim of one is gone.
    """
    try:
        return list(map(Usd.Attribute.Get, attributes, repeat(time)))
    except Tf.CppException as failure:
        raise RuntimeError(str(failure)) from None


def is_sampled(attribute: Usd.Attribute) -> bool:
    """Return whether samples, a spline or value clips give an attribute its value at the time of the context."""
    return bool(attribute) and attribute.GetResolveInfo(_time.get()).GetSource().value in _SAMPLED


def default_or_current_time(attribute: Usd.Attribute) -> Usd.TimeCode:
    """Return the time at which an attribute has the default value that stands beside samples in the same layer.

    That of the context where there are no samples, or no such value.
    """
    source = attribute.GetResolveInfo(_time.get()).GetSource()
    if source.value not in _SAMPLED or source == Usd.ResolveInfoSourceValueClips:
        return _time.get()
    stack = attribute.GetPropertyStack(_DEFAULT)
    strongest = next(spec for spec in stack if spec.HasDefaultValue() or spec.GetNumTimeSamples() or spec.HasSpline())
    return _DEFAULT if strongest.HasDefaultValue() else _time.get()


def first_time(stage: Usd.Stage) -> Usd.TimeCode:
    """Return the time at which a stage begins, for what shall not depend on the frame.

    Attributes without samples have their default value there, and those with samples have one, unlike at the default
    time.
    """
    return Usd.TimeCode(stage.GetStartTimeCode())


def transform_varies(prim: Usd.Prim) -> bool:
    """Return whether the local transform of a prim varies with time, whatever is above it; a single sample does not."""
    xformable = UsdGeom.Xformable(prim)
    return bool(xformable) and xformable.TransformMightBeTimeVarying()


def attributes_with_values(prim: Usd.Prim) -> list[Usd.Attribute]:
    """Return the attributes of a prim that are authored, or all where value clips may give values to others."""
    return prim.GetAttributes() if _is_in_clips(prim) else prim.GetAuthoredAttributes()


def _is_in_clips(prim: Usd.Prim) -> bool:
    """Return whether value clips give values to a prim: they stand on it or on one above it."""
    while prim:
        if prim.HasAuthoredMetadata("clips"):
            return True
        prim = prim.GetParent()
    return False
