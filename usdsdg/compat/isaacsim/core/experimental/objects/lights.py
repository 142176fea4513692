"""Lights. New ones have USD's default intensity: 1, and 50000 for a distant light."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from pxr import UsdLux

from usdsdg.compat.isaacsim.core.experimental.objects.typed_prims import TypedPrims
from usdsdg.compat.wrappers.arrays import names
from usdsdg.compat.wrappers.colors import rgb_rows
from usdsdg.stage.attributes import asset_path

if TYPE_CHECKING:
    import warp as wp

    from usdsdg.compat.wrappers.arrays import Indices, Values


class Light(TypedPrims):
    """Lights of one type."""

    _schema = UsdLux.LightAPI

    @classmethod
    def _kinds(cls) -> tuple[type[Light], ...]:
        every = (CylinderLight, DiskLight, DistantLight, DomeLight, RectLight, SphereLight)
        return every if cls is Light else (cls,)

    @property
    def lights(self) -> list[UsdLux.LightAPI]:
        """Return each prim as its schema."""
        return self._schemas()

    def set_intensities(self, intensities: Values, *, indices: Indices = None) -> None:
        """Set intensities (N, 1)."""
        self._set_number("Intensity", intensities, indices)

    def get_intensities(self, *, indices: Indices = None) -> wp.array:
        """Return intensities (N, 1)."""
        return self._number("Intensity", indices)

    def set_exposures(self, exposures: Values, *, indices: Indices = None) -> None:
        """Set exposures: powers of two that scale the intensities (N, 1)."""
        self._set_number("Exposure", exposures, indices)

    def get_exposures(self, *, indices: Indices = None) -> wp.array:
        """Return exposures: powers of two that scale the intensities (N, 1)."""
        return self._number("Exposure", indices)

    def set_enabled_normalizations(self, enabled: Values, *, indices: Indices = None) -> None:
        """Set whether the power is independent of the size (N, 1)."""
        self._set_number("Normalize", enabled, indices, kind=bool)

    def get_enabled_normalizations(self, *, indices: Indices = None) -> wp.array:
        """Return whether the power is independent of the size (N, 1)."""
        return self._number("Normalize", indices)

    def set_enabled_color_temperatures(self, enabled: Values, *, indices: Indices = None) -> None:
        """Set whether color temperatures are used (N, 1)."""
        self._set_number("EnableColorTemperature", enabled, indices, kind=bool)

    def get_enabled_color_temperatures(self, *, indices: Indices = None) -> wp.array:
        """Return whether color temperatures are used (N, 1)."""
        return self._number("EnableColorTemperature", indices)

    def set_color_temperatures(self, color_temperatures: Values, *, indices: Indices = None) -> None:
        """Set color temperatures [K] (N, 1)."""
        self._set_number("ColorTemperature", color_temperatures, indices)

    def get_color_temperatures(self, *, indices: Indices = None) -> wp.array:
        """Return color temperatures [K] (N, 1)."""
        return self._number("ColorTemperature", indices)

    def set_multipliers(
        self,
        diffuse_multipliers: Values | None = None,
        specular_multipliers: Values | None = None,
        *,
        indices: Indices = None,
    ) -> None:
        """Set what scales the light on diffuse and on specular surfaces (N, 1).

        Raises:
            AssertionError: neither is given.
        """
        if diffuse_multipliers is None and specular_multipliers is None:
            raise AssertionError("give diffuse_multipliers or specular_multipliers")
        for name, values in (("Diffuse", diffuse_multipliers), ("Specular", specular_multipliers)):
            if values is not None:
                self._set_number(name, values, indices)

    def get_multipliers(self, *, indices: Indices = None) -> tuple[wp.array, wp.array]:
        """Return what scales the light on diffuse and on specular surfaces (N, 1)."""
        return self._number("Diffuse", indices), self._number("Specular", indices)

    def set_colors(
        self, colors: str | Sequence[str] | Sequence[float] | np.ndarray | wp.array, *, indices: Indices = None
    ) -> None:
        """Set the colors (N, 3), or by name."""
        count = len(self._schemas(indices))
        self._set_vector("Color", rgb_rows(colors, count), indices)

    def get_colors(self, *, indices: Indices = None) -> wp.array:
        """Return the colors (N, 3)."""
        values = [tuple(each.GetColorAttr().Get()) for each in self._schemas(indices)]
        return self._warp(np.array(values, np.float32))


class CylinderLight(Light):
    """Cylinders that emit light."""

    _schema = UsdLux.CylinderLight

    def __init__(
        self,
        paths: str | Sequence[str],
        *,
        radii: Values | None = None,
        lengths: Values | None = None,
        positions: Values | None = None,
        translations: Values | None = None,
        orientations: Values | None = None,
        scales: Values | None = None,
        reset_xform_op_properties: bool = True,
    ) -> None:
        """Wrap prims, or define them; see `XformPrim` for the poses."""
        super().__init__(
            paths, positions=positions, translations=translations, orientations=orientations,
            scales=scales, reset_xform_op_properties=reset_xform_op_properties,
        )  # fmt: skip
        if radii is not None:
            self.set_radii(radii)
        if lengths is not None:
            self.set_lengths(lengths)

    def set_radii(self, radii: Values, *, indices: Indices = None) -> None:
        """Set the radii (N, 1)."""
        self._set_number("Radius", radii, indices)

    def get_radii(self, *, indices: Indices = None) -> wp.array:
        """Return the radii (N, 1)."""
        return self._number("Radius", indices)

    def set_lengths(self, lengths: Values, *, indices: Indices = None) -> None:
        """Set the lengths along x (N, 1)."""
        self._set_number("Length", lengths, indices)

    def get_lengths(self, *, indices: Indices = None) -> wp.array:
        """Return the lengths along x (N, 1)."""
        return self._number("Length", indices)

    def set_enabled_treat_as_lines(self, enabled: Values, *, indices: Indices = None) -> None:
        """Set whether they are lines without a radius (N, 1)."""
        self._set_number("TreatAsLine", enabled, indices, kind=bool)

    def get_enabled_treat_as_lines(self, *, indices: Indices = None) -> wp.array:
        """Return whether they are lines without a radius (N, 1)."""
        return self._number("TreatAsLine", indices)


class DiskLight(Light):
    """Disks that emit light along -z."""

    _schema = UsdLux.DiskLight

    def __init__(
        self,
        paths: str | Sequence[str],
        *,
        radii: Values | None = None,
        positions: Values | None = None,
        translations: Values | None = None,
        orientations: Values | None = None,
        scales: Values | None = None,
        reset_xform_op_properties: bool = True,
    ) -> None:
        """Wrap prims, or define them; see `XformPrim` for the poses."""
        super().__init__(
            paths, positions=positions, translations=translations, orientations=orientations,
            scales=scales, reset_xform_op_properties=reset_xform_op_properties,
        )  # fmt: skip
        if radii is not None:
            self.set_radii(radii)

    def set_radii(self, radii: Values, *, indices: Indices = None) -> None:
        """Set the radii (N, 1)."""
        self._set_number("Radius", radii, indices)

    def get_radii(self, *, indices: Indices = None) -> wp.array:
        """Return the radii (N, 1)."""
        return self._number("Radius", indices)


class DistantLight(Light):
    """Lights from infinitely far away, along -z."""

    _schema = UsdLux.DistantLight

    def __init__(
        self,
        paths: str | Sequence[str],
        *,
        angles: Values | None = None,
        positions: Values | None = None,
        translations: Values | None = None,
        orientations: Values | None = None,
        scales: Values | None = None,
        reset_xform_op_properties: bool = True,
    ) -> None:
        """Wrap prims, or define them; see `XformPrim` for the poses."""
        super().__init__(
            paths, positions=positions, translations=translations, orientations=orientations,
            scales=scales, reset_xform_op_properties=reset_xform_op_properties,
        )  # fmt: skip
        if angles is not None:
            self.set_angles(angles)

    def set_angles(self, angles: Values, *, indices: Indices = None) -> None:
        """Set the angular sizes [degrees] (N, 1)."""
        self._set_number("Angle", angles, indices)

    def get_angles(self, *, indices: Indices = None) -> wp.array:
        """Return the angular sizes [degrees] (N, 1)."""
        return self._number("Angle", indices)


class DomeLight(Light):
    """Skies."""

    _schema = UsdLux.DomeLight

    def __init__(
        self,
        paths: str | Sequence[str],
        *,
        radii: Values | None = None,
        texture_files: str | Sequence[str] | None = None,
        texture_formats: str | Sequence[str] | None = None,
        positions: Values | None = None,
        translations: Values | None = None,
        orientations: Values | None = None,
        scales: Values | None = None,
        reset_xform_op_properties: bool = True,
    ) -> None:
        """Wrap prims, or define them; see `XformPrim` for the poses."""
        super().__init__(
            paths, positions=positions, translations=translations, orientations=orientations,
            scales=scales, reset_xform_op_properties=reset_xform_op_properties,
        )  # fmt: skip
        if radii is not None:
            self.set_guide_radii(radii)
        if texture_files is not None:
            self.set_texture_files(texture_files)
        if texture_formats is not None:
            self.set_texture_formats(texture_formats)

    def set_guide_radii(self, radii: Values, *, indices: Indices = None) -> None:
        """Set the radii with which viewers draw them (N, 1)."""
        self._set_number("GuideRadius", radii, indices)

    def get_guide_radii(self, *, indices: Indices = None) -> wp.array:
        """Return the radii with which viewers draw them (N, 1)."""
        return self._number("GuideRadius", indices)

    def set_texture_files(self, texture_files: str | Sequence[str], *, indices: Indices = None) -> None:
        """Set the images that the light shows: files, or URLs under the assets root."""
        schemas = self._schemas(indices)
        for each, file in zip(schemas, names(texture_files, len(schemas)), strict=True):
            each.CreateTextureFileAttr().Set(asset_path(file))

    def get_texture_files(self, *, indices: Indices = None) -> list[str | None]:
        """Return the images that the light shows; None where there is none."""
        files = [each.GetTextureFileAttr().Get() for each in self._schemas(indices)]
        return [file.path if file else None for file in files]

    def set_texture_formats(self, texture_formats: str | Sequence[str], *, indices: Indices = None) -> None:
        """Set how images are projected: "automatic", "latlong", "mirroredBall", "angular", "cubeMapVerticalCross"."""
        self._set_text("TextureFormat", texture_formats, indices)

    def get_texture_formats(self, *, indices: Indices = None) -> list[str]:
        """Return how images are projected."""
        return [str(each.GetTextureFormatAttr().Get()) for each in self._schemas(indices)]


class RectLight(Light):
    """Rectangles that emit light along -z."""

    _schema = UsdLux.RectLight

    def __init__(
        self,
        paths: str | Sequence[str],
        *,
        widths: Values | None = None,
        heights: Values | None = None,
        texture_files: str | Sequence[str] | None = None,
        positions: Values | None = None,
        translations: Values | None = None,
        orientations: Values | None = None,
        scales: Values | None = None,
        reset_xform_op_properties: bool = True,
    ) -> None:
        """Wrap prims, or define them; see `XformPrim` for the poses."""
        super().__init__(
            paths, positions=positions, translations=translations, orientations=orientations,
            scales=scales, reset_xform_op_properties=reset_xform_op_properties,
        )  # fmt: skip
        if widths is not None:
            self.set_widths(widths)
        if heights is not None:
            self.set_heights(heights)
        if texture_files is not None:
            self.set_texture_files(texture_files)

    def set_widths(self, widths: Values, *, indices: Indices = None) -> None:
        """Set the sizes along x (N, 1)."""
        self._set_number("Width", widths, indices)

    def get_widths(self, *, indices: Indices = None) -> wp.array:
        """Return the sizes along x (N, 1)."""
        return self._number("Width", indices)

    def set_heights(self, heights: Values, *, indices: Indices = None) -> None:
        """Set the sizes along y (N, 1)."""
        self._set_number("Height", heights, indices)

    def get_heights(self, *, indices: Indices = None) -> wp.array:
        """Return the sizes along y (N, 1)."""
        return self._number("Height", indices)

    def set_texture_files(self, texture_files: str | Sequence[str], *, indices: Indices = None) -> None:
        """Set the images that the light shows: files, or URLs under the assets root."""
        schemas = self._schemas(indices)
        for each, file in zip(schemas, names(texture_files, len(schemas)), strict=True):
            each.CreateTextureFileAttr().Set(asset_path(file))

    def get_texture_files(self, *, indices: Indices = None) -> list[str | None]:
        """Return the images that the light shows; None where there is none."""
        files = [each.GetTextureFileAttr().Get() for each in self._schemas(indices)]
        return [file.path if file else None for file in files]


class SphereLight(Light):
    """Spheres that emit light."""

    _schema = UsdLux.SphereLight

    def __init__(
        self,
        paths: str | Sequence[str],
        *,
        radii: Values | None = None,
        positions: Values | None = None,
        translations: Values | None = None,
        orientations: Values | None = None,
        scales: Values | None = None,
        reset_xform_op_properties: bool = True,
    ) -> None:
        """Wrap prims, or define them; see `XformPrim` for the poses."""
        super().__init__(
            paths, positions=positions, translations=translations, orientations=orientations,
            scales=scales, reset_xform_op_properties=reset_xform_op_properties,
        )  # fmt: skip
        if radii is not None:
            self.set_radii(radii)

    def set_radii(self, radii: Values, *, indices: Indices = None) -> None:
        """Set the radii (N, 1)."""
        self._set_number("Radius", radii, indices)

    def get_radii(self, *, indices: Indices = None) -> wp.array:
        """Return the radii (N, 1)."""
        return self._number("Radius", indices)

    def set_enabled_treat_as_points(self, enabled: Values, *, indices: Indices = None) -> None:
        """Set whether they are points without a radius (N, 1)."""
        self._set_number("TreatAsPoint", enabled, indices, kind=bool)

    def get_enabled_treat_as_points(self, *, indices: Indices = None) -> wp.array:
        """Return whether they are points without a radius (N, 1)."""
        return self._number("TreatAsPoint", indices)
