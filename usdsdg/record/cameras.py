"""Cameras as plain values, and back."""

import dataclasses
import functools
from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.stage.cameras.camera_view import CameraView
from usdsdg.stage.cameras.lens_attributes import LensParameters

# `attributes` has everything else that is authored, on which no label depends.
_LEFT_OUT = ("attributes", "local_to_world", "lens_parameters")


def described(view: CameraView) -> dict[str, Any]:
    """Return what labels depend on, for JSON."""
    return {
        **{name: getattr(view, name) for name in _names_of(type(view)) if name not in _LEFT_OUT},
        "local_to_world": np.asarray(view.local_to_world, np.float64).ravel().tolist(),
        "lens_parameters": {name: getattr(view.lens_parameters, name) for name in _names_of(LensParameters)},
    }


@functools.cache
def _names_of(described: type) -> tuple[str, ...]:
    return tuple(each.name for each in dataclasses.fields(described))


def camera(values: Mapping[str, Any]) -> CameraView:
    """Return the camera of `described`.

    Raises:
        KeyError, TypeError, ValueError: the values describe none.
    """
    lens: dict[str, Any] = {
        name: tuple(v) if isinstance(v, list) else v for name, v in values["lens_parameters"].items()
    }
    near, far = values["clipping_range"]
    return CameraView(
        **{
            **values,
            "local_to_world": np.array(values["local_to_world"], np.float64).reshape(4, 4),
            "clipping_range": (float(near), float(far)),
            "lens_parameters": LensParameters(**lens),
        }
    )
