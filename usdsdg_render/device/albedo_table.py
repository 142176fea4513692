"""Directional-albedo table of GGX lobes, for energy compensation."""

from functools import lru_cache

import numpy as np

from usdsdg_render.kernels.bsdf.bsdf import MIN_ALPHA

# Nodes along the square root of the viewer's cosine, and along roughness. Bilinear interpolation has an error of 0.2 %
# on average, and of 3 % at grazing angles of smooth surfaces.
NODES = 32
MIN_ROOT = 0.02
_QUADRATURE = 24


@lru_cache(maxsize=1)
def albedo_table() -> np.ndarray:
    """Compute the table, (NODES, NODES, 2) float32: a, b by roughness and square root of the cosine.

    A lobe with reflectance f0 at normal and f90 at grazing incidence has the directional albedo f0 * a + f90 * b:
    Schlick's Fresnel term integrated over visible facets, with height-correlated shadowing.
    """
    cos_o = (np.linspace(MIN_ROOT, 1, NODES) ** 2)[None, :, None]
    alpha = np.maximum(np.linspace(0, 1, NODES) ** 2, float(MIN_ALPHA))[:, None, None]
    r = (np.arange(_QUADRATURE) + 0.5) / _QUADRATURE
    around, up = (each.reshape(1, 1, -1) for each in np.meshgrid(2 * np.pi * r, r))
    # Visible normals are sampled by spherical caps, as in kernels/bsdf/bsdf.py; the viewer lies in the plane y = 0.
    sin_o = np.sqrt(1 - cos_o**2)
    length = np.hypot(alpha * sin_o, cos_o)
    stretched_x, stretched_z = alpha * sin_o / length, cos_o / length
    z = (1 - up) * (1 + stretched_z) - stretched_z
    s = np.sqrt(np.clip(1 - z * z, 0, 1))
    x, y = alpha * (s * np.cos(around) + stretched_x), alpha * s * np.sin(around)
    z = np.maximum(z + stretched_z, 0)
    length = np.sqrt(x * x + y * y + z * z)
    cos_d = np.clip((x * sin_o + z * cos_o) / length, 0, 1)
    cos_i = np.maximum(2 * cos_d * z / length - cos_o, 0)
    root_i, root_o = (np.sqrt(alpha**2 + (1 - alpha**2) * c**2) for c in (cos_i, cos_o))
    weight = cos_i * (cos_o + root_o) / np.maximum(cos_i * root_o + cos_o * root_i, 1e-12)
    grazing = (1 - cos_d) ** 5
    return np.stack([(weight * (1 - grazing)).mean(-1), (weight * grazing).mean(-1)], -1).astype(np.float32)
