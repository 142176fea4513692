"""Node types of `omni.sensors.nv.camera`: the steps of `camera_signal` as nodes of a render product's graph."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from usdsdg.compat.omni.graph import camera_signal
from usdsdg.compat.omni.graph.camera_signal import Signal
from usdsdg.errors import ArgumentError

Inputs = Mapping[str, Any]

# Annotator of each image that a texture node reads.
AOVS = {"LDR": "rgb", "HDR": "HdrColor", "HDR32": "HdrColor", "DEPTH": "distance_to_image_plane"}


@dataclass(frozen=True)
class Tick:
    """One evaluation of a graph: the arrays of its render product by annotator, and its number from 0."""

    images: Mapping[str, np.ndarray]
    number: int
    rng: np.random.Generator


Compute = Callable[[Signal | None, Inputs, Tick], Signal | None]


@dataclass(frozen=True)
class NodeType:
    """A node type: what it computes from the signal at its input "src", and its other inputs with their defaults."""

    compute: Compute
    inputs: Mapping[str, Any]


def _nothing(source: Signal | None, inputs: Inputs, tick: Tick) -> None:
    return None


def _texture(source: Signal | None, inputs: Inputs, tick: Tick) -> Signal:
    array = tick.images[annotator_of(inputs)]
    if inputs["aov"] == "HDR32":
        array = array.astype(np.float32)
    return Signal(array, 255.0 if array.dtype == np.uint8 else 1.0)


def annotator_of(inputs: Inputs) -> str:
    """Return the annotator of the image that a texture node reads.

    Raises:
        ArgumentError: there is no such image.
    """
    if inputs["aov"] not in AOVS:
        raise ArgumentError(f"CamTextureReadTaskNode: aov is {inputs['aov']!r}; expected {', '.join(AOVS)}")
    return AOVS[inputs["aov"]]


def _color_correction(source: Signal | None, inputs: Inputs, tick: Tick) -> Signal:
    matrix = np.array([[inputs[f"{a}{b}"] for b in "rgb"] for a in "RGB"], np.float32)
    return camera_signal.color_correction(
        _given(source), matrix=matrix, white_balance=inputs["whiteBalance"], black=inputs["black"],
        fullwell_black=inputs["fullwell_black"], swap_red_blue=bool(inputs["redBlueSwap"]),
        half=bool(inputs["output_float16"]),
    )  # fmt: skip


def _mosaic(source: Signal | None, inputs: Inputs, tick: Tick) -> Signal:
    return camera_signal.mosaic(
        _given(source), filters=[inputs[f"CFA_CF{place}"] for place in ("00", "01", "10", "11")],
        white=int(inputs["maximalValue"]), flip_horizontal=bool(inputs["flipHorizontal"]),
        flip_vertical=bool(inputs["flipVertical"]),
    )  # fmt: skip


def _noise(source: Signal | None, inputs: Inputs, tick: Tick) -> Signal:
    return camera_signal.noise(
        _given(source), dark_gain=inputs["darkShotNoiseGain"], dark_sigma=inputs["darkShotNoiseSigma"],
        zones=inputs["hdrCombinationData"], rng=tick.rng,
    )  # fmt: skip


def _compand(source: Signal | None, inputs: Inputs, tick: Tick) -> Signal:
    return camera_signal.compand(_given(source), **_companding(inputs))


def _decompand(source: Signal | None, inputs: Inputs, tick: Tick) -> Signal:
    signal = camera_signal.decompand(_given(source), **_companding(inputs))
    return camera_signal.in_format(signal, "UINT16") if inputs["ConvertTo16bit"] else signal


def _companding(inputs: Inputs) -> dict[str, Any]:
    return {
        "curve": inputs["LinearCompandCoeff"], "before": inputs["PrePedestal"], "after": inputs["PostPedestal"],
        "alignment": inputs["Alignment"],
    }  # fmt: skip


def _demosaic(source: Signal | None, inputs: Inputs, tick: Tick) -> Signal:
    return camera_signal.demosaic(_given(source), grid=inputs["bayerGrid"], output=inputs["outputFormat"])


def _converted(source: Signal | None, inputs: Inputs, tick: Tick) -> Signal:
    gamma = bool(inputs["uintApplyGammaCorrection"])
    return camera_signal.in_format(_given(source), inputs["rgbaDataType"], gamma=gamma)


def _without_alpha(source: Signal | None, inputs: Inputs, tick: Tick) -> Signal:
    image = _given(source)
    return Signal(image.pixels[..., :3], image.white)


def _write(source: Signal | None, inputs: Inputs, tick: Tick) -> Signal:
    """Write the pixels row by row; the number of the frame goes before the suffix, as in name.0.bin of name..bin."""
    image = _given(source)
    path = Path(str(inputs["filename"]))
    pixels = np.ascontiguousarray(image.pixels).tobytes()
    if inputs["eachFrameOneFile"]:
        number = 0 if inputs["onlyLastFrame"] else tick.number
        path.with_name(f"{path.stem.rstrip('.')}.{number}{path.suffix}").write_bytes(pixels)
    else:
        with path.open("wb" if inputs["onlyLastFrame"] or tick.number == 0 else "ab") as file:
            file.write(pixels)
    return image


def _given(source: Signal | None) -> Signal:
    if source is None:
        raise ArgumentError("camera graph: a node has no image at inputs:src; connect outputs:dest of another to it")
    return source


_CAMERA = "omni.sensors.nv.camera."
_CURVE = {"LinearCompandCoeff": [], "PrePedestal": 0, "PostPedestal": 0, "Alignment": None}

NODE_TYPES: dict[str, NodeType] = {
    "omni.graph.nodes.GpuInteropRenderProductEntry": NodeType(_nothing, {}),
    f"{_CAMERA}CamTextureReadTaskNode": NodeType(_texture, {"aov": "LDR"}),
    f"{_CAMERA}ColorCorrectionTaskNode": NodeType(
        _color_correction,
        {**{f"{a}{b}": float(a.lower() == b) for a in "RGB" for b in "rgb"}, "whiteBalance": [1.0, 1.0, 1.0],
         "black": 0.0, "fullwell_black": 1.0, "output_float16": False, "redBlueSwap": False},
    ),
    f"{_CAMERA}CamCfa2x2EncoderTaskNode": NodeType(
        _mosaic,
        {"CFA_CF00": [1, 0, 0], "CFA_CF01": [0, 1, 0], "CFA_CF10": [0, 1, 0], "CFA_CF11": [0, 0, 1],
         "cfaSemantic": "RGGB", "maximalValue": 16777215, "flipHorizontal": False, "flipVertical": False},
    ),
    f"{_CAMERA}CamGeneralPurposeNoiseTask": NodeType(
        _noise, {"darkShotNoiseGain": 0.0, "darkShotNoiseSigma": 0.0, "hdrCombinationData": []}
    ),
    f"{_CAMERA}CamCompandingTaskNode": NodeType(_compand, _CURVE),
    f"{_CAMERA}CamIspDecompandingTaskNode": NodeType(_decompand, {**_CURVE, "ConvertTo16bit": False}),
    f"{_CAMERA}CamIspRGGBDemosaicingTaskNode": NodeType(_demosaic, {"bayerGrid": "RGGB", "outputFormat": "UINT8"}),
    f"{_CAMERA}CamRGBADatatypeConverterTaskNode": NodeType(
        _converted, {"rgbaDataType": "UINT8", "uintApplyGammaCorrection": False}
    ),
    f"{_CAMERA}CamRGBEncoderTaskNode": NodeType(_without_alpha, {}),
    f"{_CAMERA}CamFileWriterTaskNode": NodeType(
        _write, {"filename": "", "eachFrameOneFile": False, "onlyLastFrame": False}
    ),
}  # fmt: skip
