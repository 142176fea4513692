"""Calibrated cameras of every projection, for tests of all that sends rays through a lens."""

from __future__ import annotations

from usdsdg.stage.lens_attributes import LensParameters

# A strong barrel, decentred, with its own aspect; coefficients like those that calibrations give.
_BARREL = LensParameters(
    nominal_size=(1920.0, 1200.0),
    centre=(943.8, 602.3),
    focal=(640.0, 620.0),
    max_fov=170.0,
    polynomial=(-0.08, 0.012, -0.003, 0.02, -0.001, 0.0002),
    tangential=(0.0011, -0.0007),
    thin_prism=(-0.0006, 0.0002, 0.0019, -0.0003),
)
# NVIDIA's f-theta lens for 1936 x 1216 pixels: the default of Omniverse's property window.
F_THETA = LensParameters(
    polynomial=(0.0, 2.45417095720768e-3, 3.72747912535942e-8, -1.43520517692508e-9, 9.76e-13, 0.0)
)

# Arguments of CameraView.
CASES = {
    "pinhole": {},
    "orthographic": dict(projection_type="orthographic", horizontal_aperture=60.0),
    "pinholeOpenCV": dict(projection_type="pinholeOpenCV", lens_parameters=_BARREL),
    "pinholeOpenCV by default": dict(projection_type="pinholeOpenCV"),
    "fisheyeOpenCV": dict(projection_type="fisheyeOpenCV", lens_parameters=_BARREL),
    "fisheyePolynomial": dict(projection_type="fisheyePolynomial", lens_parameters=F_THETA),
    "fisheyePolynomial by default": dict(projection_type="fisheyePolynomial"),
    "fisheyeKannalaBrandtK3": dict(projection_type="fisheyeKannalaBrandtK3", lens_parameters=_BARREL, focal_length=8.0),
    "fisheyeRadTanThinPrism": dict(projection_type="fisheyeRadTanThinPrism", lens_parameters=_BARREL, focal_length=8.0),
    "fisheyeSpherical": dict(projection_type="fisheyeSpherical"),
    "fisheyeOrthographic": dict(projection_type="fisheyeOrthographic", focal_length=6.0),
    "fisheyeEquidistant": dict(projection_type="fisheyeEquidistant", focal_length=3.0, vertical_aperture_offset=2.0),
    "fisheyeEquisolid": dict(projection_type="fisheyeEquisolid", focal_length=3.0),
}
LENSES = {name: values for name, values in CASES.items() if name not in ("pinhole", "orthographic")}
