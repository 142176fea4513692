"""Annotators of light AOVs: outgoing radiance by light path; and of ambient occlusion.

They are the path tracer's light AOVs (see `PathSettings.light_aovs`) in either render mode, before any denoising. With
emission (PtSelfIllumination) and background (PtBackground) they add up to HdrColor.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.annotators.base import Annotation, define
from usdsdg.annotators.frame import Frame
from usdsdg.annotators.pixels import encodings
from usdsdg.annotators.pixels.encodings import HALF_MAX

Params = Mapping[str, Any]


@define("DirectDiffuse", aovs=["direct_diffuse"], needs_path_tracing=True, dtype=np.float16)
def direct_diffuse(frame: Frame, params: Params) -> Annotation:
    """Diffuse reflection of direct light and environment [nits], float16 (H, W, 4); the fourth channel is 1."""
    return Annotation(encodings.halves(frame.image("direct_diffuse"), limit=HALF_MAX))


@define("DirectSpecular", aovs=["direct_specular"], needs_path_tracing=True, dtype=np.float16)
def direct_specular(frame: Frame, params: Params) -> Annotation:
    """Specular reflection of direct light and environment [nits], float16 (H, W, 4); the fourth channel is 1."""
    return Annotation(encodings.halves(frame.image("direct_specular"), limit=HALF_MAX))


@define("PtDirectIllumation", aovs=["direct_diffuse", "direct_specular"], needs_path_tracing=True, dtype=np.float16)
def direct_illumination(frame: Frame, params: Params) -> Annotation:
    """Sum of DirectDiffuse and DirectSpecular [nits], float16 (H, W, 4); the fourth channel is 1.

    The spelling of the name is Replicator's.
    """
    diffuse, specular = frame.image("direct_diffuse"), frame.image("direct_specular")
    return Annotation(encodings.halves(diffuse, plus=specular, limit=HALF_MAX))


@define("IndirectDiffuse", "PtGlobalIllumination", aovs=["indirect_diffuse"], needs_path_tracing=True, dtype=np.float16)
def indirect_diffuse(frame: Frame, params: Params) -> Annotation:
    """Diffuse reflection of light from other surfaces [nits], float16 (H, W, 4); the fourth channel is 1."""
    return Annotation(encodings.halves(frame.image("indirect_diffuse"), limit=HALF_MAX))


@define("PtReflections", aovs=["reflections"], needs_path_tracing=True, dtype=np.float16)
def reflections(frame: Frame, params: Params) -> Annotation:
    """Specular reflection of light from other surfaces [nits], float16 (H, W, 4); the fourth channel is 1."""
    return Annotation(encodings.halves(frame.image("reflections"), limit=HALF_MAX))


@define("Reflections", aovs=["reflections"], needs_path_tracing=True, dtype=np.float32)
def reflections_of_real_time(frame: Frame, params: Params) -> Annotation:
    """PtReflections as float32 (H, W, 4)."""
    return Annotation(encodings.floats(frame.image("reflections"), 1.0))


@define("PtRefractions", aovs=["refractions"], needs_path_tracing=True, dtype=np.float16)
def refractions(frame: Frame, params: Params) -> Annotation:
    """Light transmitted by glass [nits], float16 (H, W, 4); the fourth channel is 1."""
    return Annotation(encodings.halves(frame.image("refractions"), limit=HALF_MAX))


@define("PtRefractionFilter", aovs=["transmission"], dtype=np.float16)
def refraction_filter(frame: Frame, params: Params) -> Annotation:
    """Transmittance of glass, linear, float16 (H, W, 4): 0 for other materials; the fourth channel is 1."""
    return Annotation(encodings.halves(frame.image("transmission"), limit=HALF_MAX))


@define("PtVolumes", aovs=["instance"], dtype=np.float16)
def volumes(frame: Frame, params: Params) -> Annotation:
    """Light of volumes, float16 (H, W, 4): 0, and 1 in the fourth channel.

    Volumes are not rendered; each is named in a warning when the stage is read.
    """
    return Annotation(frame.black)


@define("AmbientOcclusion", aovs=["ambient_occlusion"], dtype=np.float16)
def ambient_occlusion(frame: Frame, params: Params) -> Annotation:
    """Ambient occlusion within 0.35 m, cosine-weighted, float16 (H, W, 4): 1 is unoccluded.

    Equal in the first three channels; 1 where nothing is hit, and in the fourth channel.
    """
    return Annotation(encodings.halves(frame.image("ambient_occlusion")))
