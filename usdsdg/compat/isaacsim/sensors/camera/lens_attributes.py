"""Attributes of a camera prim in the units of Isaac Sim's camera classes, and its lens distortion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from pxr import Gf, Sdf, Usd

from usdsdg.errors import ArgumentError, warn_once

# Focal lengths and apertures of USD are in tenths of stage units.
TENTHS = 10.0

# Of each distortion schema: the value of omni:lensdistortion:model, and the names of its coefficients.
MODELS: dict[str, tuple[str, tuple[str, ...]]] = {
    "OmniLensDistortionFthetaAPI": ("ftheta", ("k0", "k1", "k2", "k3", "k4")),
    "OmniLensDistortionKannalaBrandtK3API": ("kannalaBrandtK3", ("k0", "k1", "k2", "k3")),
    "OmniLensDistortionRadTanThinPrismAPI": (
        "radTanThinPrism", ("k0", "k1", "k2", "k3", "k4", "k5", "p0", "p1", "s0", "s1", "s2", "s3"),
    ),
    "OmniLensDistortionLutAPI": ("lut", ()),
    "OmniLensDistortionOpenCvFisheyeAPI": ("opencvFisheye", ("k1", "k2", "k3", "k4")),
    "OmniLensDistortionOpenCvPinholeAPI": (
        "opencvPinhole", ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4"),
    ),
}  # fmt: skip
_MODEL = "omni:lensdistortion:model"


class LensAttributes:
    """The lens of a camera prim: lengths are stage units, distortion is that of an `OmniLensDistortion...API`."""

    if TYPE_CHECKING:  # of the camera class

        @property
        def prim(self) -> Usd.Prim: ...

        def get_resolution(self) -> tuple[int, int]: ...

    # --- pinhole ---
    def get_focal_length(self) -> float:
        return self.prim.GetAttribute("focalLength").Get() / TENTHS

    def set_focal_length(self, value: float) -> None:
        self.prim.GetAttribute("focalLength").Set(float(value) * TENTHS)

    def get_focus_distance(self) -> float:
        return self.prim.GetAttribute("focusDistance").Get()

    def set_focus_distance(self, value: float) -> None:
        self.prim.GetAttribute("focusDistance").Set(float(value))

    def get_lens_aperture(self) -> float:
        """Return the f-number; 0 means that everything is in focus."""
        return self.prim.GetAttribute("fStop").Get()

    def set_lens_aperture(self, value: float) -> None:
        self.prim.GetAttribute("fStop").Set(float(value))

    def get_horizontal_aperture(self) -> float:
        return self.prim.GetAttribute("horizontalAperture").Get() / TENTHS

    def set_horizontal_aperture(self, value: float, maintain_square_pixels: bool = True) -> None:
        """Set the width of the sensor, and with square pixels its height too."""
        self.prim.GetAttribute("horizontalAperture").Set(float(value) * TENTHS)
        if maintain_square_pixels:
            self._square_pixels("vertical")

    def get_vertical_aperture(self) -> float:
        return self.prim.GetAttribute("verticalAperture").Get() / TENTHS

    def set_vertical_aperture(self, value: float, maintain_square_pixels: bool = True) -> None:
        """Set the height of the sensor, and with square pixels its width too."""
        self.prim.GetAttribute("verticalAperture").Set(float(value) * TENTHS)
        if maintain_square_pixels:
            self._square_pixels("horizontal")

    def get_clipping_range(self) -> tuple[float, float]:
        near, far = self.prim.GetAttribute("clippingRange").Get()
        return near, far

    def set_clipping_range(self, near_distance: float | None = None, far_distance: float | None = None) -> None:
        """Set the near and far distance; what is not given stays."""
        near, far = self.get_clipping_range()
        near, far = near if near_distance is None else near_distance, far if far_distance is None else far_distance
        self.prim.GetAttribute("clippingRange").Set(Gf.Vec2f(near, far))

    def get_projection_mode(self) -> str:
        """Return "perspective" or "orthographic"."""
        return self.prim.GetAttribute("projection").Get()

    def set_projection_mode(self, value: str) -> None:
        self._set_choice("projection", value, ("perspective", "orthographic"))

    def get_stereo_role(self) -> str:
        """Return "mono", "left" or "right"."""
        return self.prim.GetAttribute("stereoRole").Get()

    def set_stereo_role(self, value: str) -> None:
        self._set_choice("stereoRole", value, ("mono", "left", "right"))

    def get_shutter_properties(self) -> tuple[float, float]:
        """Return when the shutter opens and closes [time codes]."""
        return self.prim.GetAttribute("shutter:open").Get(), self.prim.GetAttribute("shutter:close").Get()

    def set_shutter_properties(self, delay_open: float | None = None, delay_close: float | None = None) -> None:
        """Set when the shutter opens and closes; 0 and None leave a value."""
        for name, value in (("shutter:open", delay_open), ("shutter:close", delay_close)):
            if value:
                self.prim.GetAttribute(name).Set(float(value))

    # --- distortion ---
    def get_lens_distortion_model(self) -> str:
        """Return the value of omni:lensdistortion:model, or "pinhole"."""
        return self.prim.GetAttribute(_MODEL).Get() or "pinhole"

    def set_lens_distortion_model(self, value: str) -> None:
        """Apply the schema of that name; "pinhole" removes the schemas."""
        if value == "pinhole":
            for schema in self.prim.GetAppliedSchemas():
                if schema.startswith("OmniLensDistortion"):
                    self.prim.RemoveAppliedSchema(schema)
            self.prim.RemoveProperty(_MODEL)
        elif value in MODELS:
            self.prim.ApplyAPI(value)
            self.prim.GetAttribute(_MODEL).Set(MODELS[value][0])
        else:
            warn_once(f"{self.prim.GetPath()}: {value!r} is no distortion model; expected pinhole, {', '.join(MODELS)}")

    def get_projection_type(self) -> str:
        """Return the older attribute cameraProjectionType, or "pinhole"."""
        return self.prim.GetAttribute("cameraProjectionType").Get() or "pinhole"

    def set_projection_type(self, value: str) -> None:
        """Set the older attribute cameraProjectionType; "pinhole" also removes distortion."""
        if value == "pinhole":
            self.set_lens_distortion_model(value)
        attribute = self.prim.GetAttribute("cameraProjectionType")
        attribute = attribute or self.prim.CreateAttribute("cameraProjectionType", Sdf.ValueTypeNames.Token)
        attribute.Set(value)

    def set_fisheye_polynomial_properties(
        self,
        nominal_width: float | None,
        nominal_height: float | None,
        optical_centre_x: float | None,
        optical_centre_y: float | None,
        max_fov: float | None,
        polynomial: Sequence[float | None] | None,
    ) -> None:
        """Set the older attributes of a polynomial fisheye: sizes and center [pixels], field of view [degrees].

        Raises:
            ArgumentError: the projection type is no fisheye.
        """
        self._check_fisheye("set_fisheye_polynomial_properties")
        values = {
            "fthetaWidth": nominal_width, "fthetaHeight": nominal_height, "fthetaCx": optical_centre_x,
            "fthetaCy": optical_centre_y, "fthetaMaxFov": max_fov,
            **{f"fthetaPoly{letter}": each for letter, each in zip("ABCDE", polynomial or ())},
        }  # fmt: skip
        for name, value in values.items():
            if value is not None:
                self.prim.CreateAttribute(name, Sdf.ValueTypeNames.Float).Set(float(value))

    def get_fisheye_polynomial_properties(self) -> tuple[Any, ...]:
        """Return nominal width and height, center x and y [pixels], field of view [degrees], and five coefficients.

        Raises:
            ArgumentError: the projection type is no fisheye.
        """
        self._check_fisheye("get_fisheye_polynomial_properties")
        names = ("Width", "Height", "Cx", "Cy", "MaxFov")
        values = (self.prim.GetAttribute(f"ftheta{name}").Get() for name in names)
        return *values, [self.prim.GetAttribute(f"fthetaPoly{letter}").Get() for letter in "ABCDE"]

    def set_ftheta_properties(
        self,
        nominal_height: float | None = None,
        nominal_width: float | None = None,
        optical_center: Sequence[float] | None = None,
        max_fov: float | None = None,
        distortion_coefficients: Sequence[float] | None = None,
    ) -> None:
        """Apply the F-theta model: sizes and center [pixels], field of view [degrees], k0 to k4."""
        self._set_nominal("OmniLensDistortionFthetaAPI", nominal_height, nominal_width, optical_center,
                          distortion_coefficients, maxFov=max_fov)  # fmt: skip

    def get_ftheta_properties(self) -> tuple[Any, ...] | None:
        return self._get("OmniLensDistortionFthetaAPI", "nominalHeight", "nominalWidth", "opticalCenter", "maxFov")

    def set_kannala_brandt_k3_properties(
        self,
        nominal_height: float | None = None,
        nominal_width: float | None = None,
        optical_center: Sequence[float] | None = None,
        max_fov: float | None = None,
        distortion_coefficients: Sequence[float] | None = None,
    ) -> None:
        """Apply the Kannala-Brandt K3 model: sizes and center [pixels], field of view [degrees], k0 to k3."""
        self._set_nominal("OmniLensDistortionKannalaBrandtK3API", nominal_height, nominal_width, optical_center,
                          distortion_coefficients, maxFov=max_fov)  # fmt: skip

    def get_kannala_brandt_k3_properties(self) -> tuple[Any, ...] | None:
        names = ("nominalHeight", "nominalWidth", "opticalCenter", "maxFov")
        return self._get("OmniLensDistortionKannalaBrandtK3API", *names)

    def set_rad_tan_thin_prism_properties(
        self,
        nominal_height: float | None = None,
        nominal_width: float | None = None,
        optical_center: Sequence[float] | None = None,
        max_fov: float | None = None,
        distortion_coefficients: Sequence[float] | None = None,
    ) -> None:
        """Apply the radial, tangential and thin prism model: k0 to k5, p0, p1, s0 to s3."""
        self._set_nominal("OmniLensDistortionRadTanThinPrismAPI", nominal_height, nominal_width, optical_center,
                          distortion_coefficients, maxFov=max_fov)  # fmt: skip

    def get_rad_tan_thin_prism_properties(self) -> tuple[Any, ...] | None:
        names = ("nominalHeight", "nominalWidth", "opticalCenter", "maxFov")
        return self._get("OmniLensDistortionRadTanThinPrismAPI", *names)

    def set_lut_properties(
        self,
        nominal_height: float | None = None,
        nominal_width: float | None = None,
        optical_center: Sequence[float] | None = None,
        ray_enter_direction_texture: str | None = None,
        ray_exit_position_texture: str | None = None,
    ) -> None:
        """Apply the model of two textures."""
        self._set_nominal("OmniLensDistortionLutAPI", nominal_height, nominal_width, optical_center, None,
                          rayEnterDirectionTexture=ray_enter_direction_texture,
                          rayExitPositionTexture=ray_exit_position_texture)  # fmt: skip

    def get_lut_properties(self) -> tuple[Any, ...] | None:
        textures = ("rayEnterDirectionTexture", "rayExitPositionTexture")
        return self._get("OmniLensDistortionLutAPI", "nominalHeight", "nominalWidth", "opticalCenter", *textures)

    def set_opencv_pinhole_properties(
        self,
        cx: float | None = None,
        cy: float | None = None,
        fx: float | None = None,
        fy: float | None = None,
        pinhole: Sequence[float] | None = None,
    ) -> None:
        """Apply OpenCV's pinhole model [pixels]: k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4."""
        size = Gf.Vec2i(*self.get_resolution())
        self._set("OmniLensDistortionOpenCvPinholeAPI", pinhole, cx=cx, cy=cy, fx=fx, fy=fy, imageSize=size)

    def get_opencv_pinhole_properties(self) -> tuple[Any, ...] | None:
        return self._get("OmniLensDistortionOpenCvPinholeAPI", "cx", "cy", "fx", "fy")

    def set_opencv_fisheye_properties(
        self,
        cx: float | None = None,
        cy: float | None = None,
        fx: float | None = None,
        fy: float | None = None,
        fisheye: Sequence[float] | None = None,
    ) -> None:
        """Apply OpenCV's fisheye model [pixels]: k1 to k4."""
        size = Gf.Vec2i(*self.get_resolution())
        self._set("OmniLensDistortionOpenCvFisheyeAPI", fisheye, cx=cx, cy=cy, fx=fx, fy=fy, imageSize=size)

    def get_opencv_fisheye_properties(self) -> tuple[Any, ...] | None:
        return self._get("OmniLensDistortionOpenCvFisheyeAPI", "cx", "cy", "fx", "fy")

    def set_rational_polynomial_properties(
        self,
        nominal_width: float,
        nominal_height: float,
        optical_centre_x: float,
        optical_centre_y: float,
        max_fov: float | None,
        distortion_model: Sequence[float],
    ) -> None:
        """Apply OpenCV's pinhole model with the focal length of the prim; `max_fov` is not used."""
        fx, fy = self._focal_pixels(nominal_width, nominal_height)
        self.set_opencv_pinhole_properties(optical_centre_x, optical_centre_y, fx, fy, distortion_model)

    def set_kannala_brandt_properties(
        self,
        nominal_width: float,
        nominal_height: float,
        optical_centre_x: float,
        optical_centre_y: float,
        max_fov: float | None,
        distortion_model: Sequence[float],
    ) -> None:
        """Apply OpenCV's fisheye model with the focal length of the prim; `max_fov` is not used."""
        fx, fy = self._focal_pixels(nominal_width, nominal_height)
        self.set_opencv_fisheye_properties(optical_centre_x, optical_centre_y, fx, fy, distortion_model)

    # --- helpers ---
    def _focal_pixels(self, width: float, height: float) -> tuple[float, float]:
        focal = self.get_focal_length()
        return width * focal / self.get_horizontal_aperture(), height * focal / self.get_vertical_aperture()

    def _square_pixels(self, change: str) -> None:
        """Change one aperture, "vertical" or "horizontal", so that pixels are square."""
        width, height = self.get_resolution()
        names = {"vertical": ("horizontalAperture", height / width), "horizontal": ("verticalAperture", width / height)}
        other, ratio = names[change]
        self.prim.GetAttribute(f"{change}Aperture").Set(self.prim.GetAttribute(other).Get() * ratio)

    def _set_choice(self, name: str, value: str, choices: Sequence[str]) -> None:
        if value in choices:
            self.prim.GetAttribute(name).Set(value)
        else:
            warn_once(f"{self.prim.GetPath()}: {name} cannot be {value!r}; expected {' or '.join(choices)}")

    def _check_fisheye(self, what: str) -> None:
        if "fisheye" not in self.get_projection_type():
            raise ArgumentError(
                f"{self.prim.GetPath()}: {what} needs a fisheye; call set_projection_type('fisheyePolynomial') first"
            )

    def _set_nominal(
        self,
        schema: str,
        height: float | None,
        width: float | None,
        center: Sequence[float] | None,
        coefficients: Sequence[float] | None,
        **values: Any,
    ) -> None:
        center = None if center is None else Gf.Vec2f(*map(float, center))
        self._set(schema, coefficients, nominalHeight=height, nominalWidth=width, opticalCenter=center, **values)

    def _set(self, schema: str, coefficients: Sequence[float] | None, **values: Any) -> None:
        """Apply a model and set its attributes; None leaves one."""
        self.set_lens_distortion_model(schema)
        model, names = MODELS[schema]
        for name, value in {**values, **dict(zip(names, coefficients or ()))}.items():
            if value is not None:
                self.prim.GetAttribute(f"omni:lensdistortion:{model}:{name}").Set(value)

    def _get(self, schema: str, *names: str) -> tuple[Any, ...] | None:
        """Return attributes of a model, its coefficients last in a list; None, with a warning, if it is not applied."""
        model, coefficients = MODELS[schema]
        if self.get_lens_distortion_model() != model:
            warn_once(f"{self.prim.GetPath()}: the distortion model is {self.get_lens_distortion_model()}, not {model}")
            return None
        prefix = f"omni:lensdistortion:{model}:"
        values = tuple(self.prim.GetAttribute(prefix + name).Get() for name in names)
        listed = [self.prim.GetAttribute(prefix + name).Get() for name in coefficients]
        return (*values, listed) if coefficients else values
