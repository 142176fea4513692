"""Replicator's projection types, and the USD attributes that calibrate them: the older ones and the schemas."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pxr import Sdf, Usd

PROJECTIONS = (
    "pinhole", "pinholeOpenCV", "fisheyePolynomial", "fisheyeSpherical", "fisheyeKannalaBrandtK3", "fisheyeOpenCV",
    "fisheyeRadTanThinPrism", "omniDirectionalStereo", "generalizedProjection",
)  # fmt: skip
# Removed in Replicator 1.11.21; scripts for Isaac Sim 4.2 still use them.
OLD_PROJECTIONS = ("fisheyeOrthographic", "fisheyeEquidistant", "fisheyeEquisolid")

# Attributes of UsdGeomCamera.
OPTICS = {
    "focal_length": "focalLength",
    "focus_distance": "focusDistance",
    "f_stop": "fStop",
    "horizontal_aperture": "horizontalAperture",
    "horizontal_aperture_offset": "horizontalApertureOffset",
    "vertical_aperture_offset": "verticalApertureOffset",
}
# Attributes of Omniverse's own lens models.
LENS = {
    "fisheye_nominal_width": "fthetaWidth",
    "fisheye_nominal_height": "fthetaHeight",
    "fisheye_optical_centre_x": "fthetaCx",
    "fisheye_optical_centre_y": "fthetaCy",
    "openCV_focal_x": "openCVFx",
    "openCV_focal_y": "openCVFy",
    "fisheye_max_fov": "fthetaMaxFov",
    **{f"fisheye_polynomial_{letter}": f"fthetaPoly{letter.upper()}" for letter in "abcdef"},
    **{f"fisheye_{name}": name for name in ("p0", "p1", "s0", "s1", "s2", "s3")},
}

# Attributes of omni-directional stereo: the distance between the eyes [cm], and which eye the camera is.
EYE_DISTANCE, LEFT_EYE, STEREO_ROLE = "interpupillaryDistance", "isLeftEye", "stereoRole"
# Attributes that hold the textures of a generalized projection: directions of pixels, positions of directions.
TEXTURES = ("generalizedProjectionDirectionTexturePath", "generalizedProjectionNDCTexturePath")
_SCHEMA_TEXTURES = ("rayEnterDirectionTexture", "rayExitPositionTexture")

# The attribute that selects one of the OmniLensDistortion…API schemas, and for each of its values the projection type
# and the names of the coefficients: polynomial, tangential, thin prism.
SCHEMA_MODEL = "omni:lensdistortion:model"
_SCHEMAS: dict[str, tuple[str, tuple[str, ...]]] = {
    "ftheta": ("fisheyePolynomial", ("k0 k1 k2 k3 k4", "", "")),
    "kannalaBrandtK3": ("fisheyeKannalaBrandtK3", ("k0 k1 k2 k3", "", "")),
    "radTanThinPrism": ("fisheyeRadTanThinPrism", ("k0 k1 k2 k3 k4 k5", "p0 p1", "s0 s1 s2 s3")),
    "opencvFisheye": ("fisheyeOpenCV", ("k1 k2 k3 k4", "", "")),
    "opencvPinhole": ("pinholeOpenCV", ("k1 k2 k3 k4 k5 k6", "p1 p2", "s1 s2 s3 s4")),
    "lut": ("generalizedProjection", ("", "", "")),
    "omniDirectionalStereo": ("omniDirectionalStereo", ("", "", "")),
}


def lens_attribute_type(name: str) -> Sdf.ValueTypeName | None:
    """Return the type of an attribute of Omniverse's lens models, by its older name; None for other attributes.

    Cameras have them there without being given a value, as if by a schema.
    """
    types = {"cameraProjectionType": Sdf.ValueTypeNames.Token, LEFT_EYE: Sdf.ValueTypeNames.Bool}
    types |= dict.fromkeys((*LENS.values(), EYE_DISTANCE), Sdf.ValueTypeNames.Float)
    return (types | dict.fromkeys(TEXTURES, Sdf.ValueTypeNames.Asset)).get(name)


@dataclass(frozen=True)
class LensParameters:
    """Calibration of a lens model. Lengths are in pixels of the nominal size, from its top left corner.

    The defaults are those of cameras without the attributes, as in Replicator.
    """

    nominal_size: tuple[float, float] = (1936.0, 1216.0)  # 0 = that of the image
    center: tuple[float, float] = (970.94244, 600.37482)
    focal: tuple[float, float] = (731.78788, 731.78789)  # of OpenCV's models
    max_fov: float = 200.0  # degrees, across
    polynomial: tuple[float, ...] = (0.0, 0.00245, 0.0, 0.0, 0.0, 0.0)
    tangential: tuple[float, ...] = (-0.00037, -0.00074)
    thin_prism: tuple[float, ...] = (-0.00058, -0.00022, 0.00019, -0.0002)
    eye_distance: float = 0.064  # of omni-directional stereo [m]
    left_eye: bool = False
    direction_texture: str = ""  # of a generalized projection: files, "" = none
    position_texture: str = ""


# What is reported of a pinhole without calibration, as in Replicator.
_NO_LENS = LensParameters(
    nominal_size=(0.0, 0.0), center=(0.0, 0.0), focal=(0.0, 0.0), max_fov=0.0, polynomial=(0.0,) * 6, tangential=(),
    thin_prism=(),
)  # fmt: skip


def reported_lens(projection_type: str, lens: LensParameters) -> LensParameters:
    """Return the calibration that labels report: zeros, without coefficients, for a pinhole that has none."""
    has_none = projection_type in ("pinhole", "orthographic") and lens == LensParameters()
    return _NO_LENS if has_none else lens


def read_lens(values: Mapping[str, Any]) -> tuple[str, LensParameters]:
    """Return the projection type, by Replicator's name, and the calibration of a camera with these attributes.

    A lens distortion schema takes precedence over the older `cameraProjectionType`, and an orthographic `projection`
    over both.
    """
    model = str(values.get(SCHEMA_MODEL) or "")
    older = str(values.get("cameraProjectionType") or "pinhole")
    if values.get("projection") == "orthographic":
        return "orthographic", _older_parameters(values)
    if model in ("", "pinhole"):
        return older, _older_parameters(values)
    if model not in _SCHEMAS:
        return model, LensParameters()
    projection, coefficients = _SCHEMAS[model]
    return projection, _schema_parameters(values, model, coefficients)


def undocumented_attributes(values: Mapping[str, Any]) -> list[str]:
    """Return the names of this camera's lens attributes that are set, but have no documented meaning."""
    model = str(values.get(SCHEMA_MODEL) or "")
    prefix = f"omni:lensdistortion:{model}:"
    # The attributes of OmniLensDistortionOmniDirectionalStereoAPI are not documented.
    return [name for name in values if model == "omniDirectionalStereo" and name.startswith(prefix)]


def _older_parameters(values: Mapping[str, Any]) -> LensParameters:
    unset = LensParameters()

    def several(names: tuple[str, ...], defaults: tuple[float, ...]) -> tuple[float, ...]:
        found = [values.get(name) for name in names]
        return tuple(float(d if v is None else v) for v, d in zip(found, defaults, strict=True))

    return LensParameters(
        nominal_size=several(("fthetaWidth", "fthetaHeight"), unset.nominal_size),  # type: ignore[arg-type]
        center=several(("fthetaCx", "fthetaCy"), unset.center),  # type: ignore[arg-type]
        focal=several(("openCVFx", "openCVFy"), unset.focal),  # type: ignore[arg-type]
        max_fov=several(("fthetaMaxFov",), (unset.max_fov,))[0],
        polynomial=several(tuple(f"fthetaPoly{letter}" for letter in "ABCDEF"), unset.polynomial),
        tangential=several(("p0", "p1"), unset.tangential),
        thin_prism=several(("s0", "s1", "s2", "s3"), unset.thin_prism),
        eye_distance=several((EYE_DISTANCE,), (unset.eye_distance * 100,))[0] / 100,
        left_eye=_is_left(values),
        direction_texture=_file(values.get(TEXTURES[0])),
        position_texture=_file(values.get(TEXTURES[1])),
    )


def _is_left(values: Mapping[str, Any]) -> bool:
    """Whether this is a left eye, by Omniverse's attribute, else by UsdGeomCamera's role; False without either."""
    is_left = values.get(LEFT_EYE)
    return values.get(STEREO_ROLE) == "left" if is_left is None else bool(is_left)


def _file(value: Any) -> str:
    """Return the path of an asset: resolved where USD found it, else as authored."""
    if isinstance(value, Sdf.AssetPath):
        return value.resolvedPath or value.path
    return "" if value is None else str(value)


def _schema_parameters(values: Mapping[str, Any], model: str, coefficients: tuple[str, ...]) -> LensParameters:
    def value(name: str) -> Any:
        full = f"omni:lensdistortion:{model}:{name}"
        found = values.get(full)
        return _fallback(model, full) if found is None else found

    def several(names: str, count: int) -> tuple[float, ...]:
        found = [float(value(name)) for name in names.split()]
        return tuple(found + [0.0] * (count - len(found)))

    if model == "omniDirectionalStereo":
        return _older_parameters(values)
    if model == "lut":
        return LensParameters(
            nominal_size=(value("nominalWidth"), value("nominalHeight")),
            center=_pair(value("opticalCenter")),
            direction_texture=_file(value(_SCHEMA_TEXTURES[0])),
            position_texture=_file(value(_SCHEMA_TEXTURES[1])),
        )
    opencv = model.startswith("opencv")
    return LensParameters(
        nominal_size=_pair(value("imageSize")) if opencv else (value("nominalWidth"), value("nominalHeight")),
        center=(value("cx"), value("cy")) if opencv else _pair(value("opticalCenter")),
        focal=(value("fx"), value("fy")) if opencv else LensParameters.focal,
        max_fov=360.0 if opencv else float(value("maxFov")),
        polynomial=several(coefficients[0], 6),
        tangential=several(coefficients[1], 2),
        thin_prism=several(coefficients[2], 4),
    )


def _pair(value: Any) -> tuple[float, float]:
    return float(value[0]), float(value[1])


def _fallback(model: str, name: str) -> Any:
    """Return the schema's default, for attributes that were authored without applying the schema."""
    schema = f"OmniLensDistortion{model[0].upper()}{model[1:]}API".replace("Opencv", "OpenCv")
    return Usd.SchemaRegistry().FindAppliedAPIPrimDefinition(schema).GetAttributeFallbackValue(name)
