"""Lenses of cameras: Replicator's projections, and the USD attribute of each of its camera arguments."""

PROJECTIONS = (
    "pinhole", "pinholeOpenCV", "fisheyePolynomial", "fisheyeSpherical", "fisheyeKannalaBrandtK3", "fisheyeOpenCV",
    "fisheyeRadTanThinPrism", "omniDirectionalStereo", "generalizedProjection",
)  # fmt: skip

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
