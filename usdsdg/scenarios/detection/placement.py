"""Where objects are in the view of a camera: drawn in the picture, then put at the distance that gives their size."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from pxr import Gf

from usdsdg.stage.cameras.camera_view import CameraView

# How far the center of an object that is cut off is beyond the edge of the picture, at most: a part of its radius.
_BEYOND = 0.35
# Spheres around objects may overlap to this fraction of their distance, since few objects fill theirs.
_OVERLAP = 0.75


@dataclass(frozen=True)
class Place:
    """A place in the view: the center of an object's bounds in the camera's frame, and its turn."""

    center: np.ndarray  # (3,), x right, y up, -z ahead
    radius: float
    turn: Gf.Quatd
    pixel: tuple[float, float]
    distance: float

    def moved(self, factor: float) -> Place:
        """Return a place at a multiple of the distance that looks the same."""
        center = self.center * factor
        return replace(self, center=center, radius=self.radius * factor, distance=self.distance * factor)


def draw_place(
    generator: np.random.Generator,
    view: CameraView,
    radius: float,
    size_in_image: tuple[float, float],
    *,
    cut_off: bool = False,
) -> Place:
    """Draw size in the picture, place and turn of an object; wholly inside of the picture unless it is cut off."""
    low, high = size_in_image
    size = low * (high / low) ** generator.random()
    reach = size * view.height / 2.0  # radius in pixels
    if cut_off:
        pixel = _beside_an_edge(generator, view, reach)
    else:
        margin = [min(reach, 0.45 * extent) for extent in (view.width, view.height)]
        pixel = tuple(generator.uniform(edge, extent - edge) for edge, extent in zip(margin, (view.width, view.height)))
    return _at(generator, view, pixel, radius, reach)


def draw_distractor(
    generator: np.random.Generator, view: CameraView, size_in_image: tuple[float, float], distance: float
) -> Place:
    """Draw the place of a distractor at a distance, of the radius that gives its size; some are cut off."""
    low, high = size_in_image
    reach = low * (high / low) ** generator.random() * view.height / 2.0
    pixel = generator.uniform((0.0, 0.0), (view.width, view.height))
    return _sized(generator, view, (float(pixel[0]), float(pixel[1])), reach, distance)


def draw_in_front(
    generator: np.random.Generator, view: CameraView, hidden: Place, size_in_image: tuple[float, float]
) -> Place:
    """Draw the place of a distractor that hides a part of an object: between it and the camera, off its center."""
    reach = radius_in_pixels(view, hidden)
    low, high = (fraction * view.height / 2.0 for fraction in size_in_image)
    own = float(np.clip(reach * generator.uniform(0.45, 0.9), low, high))
    angle, away = generator.uniform(0.0, 2.0 * np.pi), generator.uniform(0.3, 0.9) * (reach + own)
    pixel = (hidden.pixel[0] + away * np.cos(angle), hidden.pixel[1] + away * np.sin(angle))
    nearest = max(hidden.distance - hidden.radius, 0.3 * hidden.distance)
    place = _sized(generator, view, pixel, own, nearest)
    fraction = nearest / (nearest + place.radius)  # its far side is before the near side of the object
    return _sized(generator, view, pixel, own, nearest * fraction * generator.uniform(0.7, 1.0))


def is_free(place: Place, others: list[Place]) -> bool:
    """Whether an object would touch none of the others."""
    return all(
        np.linalg.norm(place.center - other.center) > _OVERLAP * (place.radius + other.radius) for other in others
    )


def radius_in_pixels(view: CameraView, place: Place) -> float:
    """Return the radius of the sphere around an object [pixels]."""
    return place.radius / place.distance / _angle_of_pixel(view, place.pixel)


def _at(
    generator: np.random.Generator, view: CameraView, pixel: tuple[float, ...], radius: float, reach: float
) -> Place:
    """Return a place of an object of this radius that spans `reach` pixels from its center."""
    distance = max(radius / (reach * _angle_of_pixel(view, pixel)), 1.2 * radius)  # the camera is not inside of it
    center = _direction(view, pixel) * distance
    return Place(center, radius, _turn(generator), (float(pixel[0]), float(pixel[1])), float(distance))


def _sized(
    generator: np.random.Generator, view: CameraView, pixel: tuple[float, float], reach: float, distance: float
) -> Place:
    """Return a place at this distance, of the radius that spans `reach` pixels."""
    radius = min(reach * _angle_of_pixel(view, pixel), 0.8) * distance
    return Place(_direction(view, pixel) * distance, radius, _turn(generator), pixel, distance)


def _beside_an_edge(generator: np.random.Generator, view: CameraView, reach: float) -> tuple[float, float]:
    x, y = generator.uniform(0.0, view.width), generator.uniform(0.0, view.height)
    inside = generator.uniform(-_BEYOND, 0.8) * reach
    side = int(generator.integers(4))
    return [(inside, y), (view.width - inside, y), (x, inside), (x, view.height - inside)][side]


def _direction(view: CameraView, pixel: tuple[float, ...]) -> np.ndarray:
    """Return the unit vector (3,) that a pixel sees; of pixels that see nothing, that of the nearest that does."""
    middle = np.array((view.width / 2.0, view.height / 2.0))
    for fraction in np.linspace(1.0, 0.0, 21):
        direction = view.rays(middle + (np.asarray(pixel) - middle) * fraction)[1][0]
        if np.isfinite(direction).all():
            return direction
    return np.array((0.0, 0.0, -1.0))


def _angle_of_pixel(view: CameraView, pixel: tuple[float, ...]) -> float:
    """Return the angle between a pixel and the one below it [radians]."""
    inner = (pixel[0], min(max(pixel[1], 0.0), view.height - 1.0))
    a, b = _direction(view, inner), _direction(view, (inner[0], inner[1] + 1.0))
    return max(float(np.linalg.norm(a - b)), 1e-9)


def _turn(generator: np.random.Generator) -> Gf.Quatd:
    """Draw a rotation, all of which are equally likely."""
    w, x, y, z = generator.normal(size=4)
    return Gf.Quatd(w, x, y, z).GetNormalized()
