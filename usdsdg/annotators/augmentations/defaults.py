"""Replicator's built-in augmentations by name, those of `rep.annotators.get_augmentation`, and their nodes."""

from usdsdg.annotators.augmentations import colors, filters, geometry, images, noise
from usdsdg.annotators.augmentations.array_transform import NodeSpec, augmentations, node_specs
from usdsdg.annotators.augmentations.augmentation import Augmentation

_NODES = {
    "AugBgRandExp": NodeSpec(images.background_rand, {"instance": "instance"}),
    "AugCanny": NodeSpec(filters.canny),
    "AugContrastExp": NodeSpec(colors.contrast),
    "AugConv2dExp": NodeSpec(filters.conv2d),
    "AugCropResizeExp": NodeSpec(geometry.crop_resize),
    "AugCutMixExp": NodeSpec(images.cut_mix),
    "AugImgBlendExp": NodeSpec(images.image_blend),
    "AugMotionBlurExp": NodeSpec(filters.motion_blur),
    "AugPixellateExp": NodeSpec(filters.pixellate),
    "AugRotateExp": NodeSpec(geometry.rotate),
}
for _name, _spec in _NODES.items():
    node_specs.add(_name, _spec)

_FUNCTIONS = {
    "rgba_to_rgb": Augmentation.from_function(colors.rgba_to_rgb),
    "RgbaToRgb": Augmentation.from_function(colors.rgba_to_rgb),
    "ColorizeDepth": Augmentation.from_function(colors.colorize_depth, near=0.1, far=100.0),
    "ColorizeNormals": Augmentation.from_function(colors.colorize_normals),
    "Sobel": Augmentation.from_function(filters.sobel),
    "AdjustSigmoid": Augmentation.from_function(colors.adjust_sigmoid, cutoff=0.5, gain=1.0),
    "Brightness": Augmentation.from_function(colors.brightness, brightness_factor=2.0),
    "SpeckleNoise": Augmentation.from_function(noise.speckle_noise, sigma=0.5),
    "ShotNoise": Augmentation.from_function(noise.shot_noise, sigma=0.5),
    "RgbToHsv": Augmentation.from_function(colors.rgb_to_hsv),
    "HsvToRgb": Augmentation.from_function(colors.hsv_to_rgb),
    "GlassBlur": Augmentation.from_function(noise.glass_blur, delta=4),
    "BackgroundRand": Augmentation.from_node("AugBgRandExp"),
    "Contrast": Augmentation.from_node("AugContrastExp", contrastFactor=0.5),
    "Conv2d": Augmentation.from_node("AugConv2dExp", alpha=0.7),
    "CropResize": Augmentation.from_node("AugCropResizeExp", cropFactor=0.5, offsetFactor=(0.0, 0.0)),
    "CutMix": Augmentation.from_node("AugCutMixExp"),
    "ImageBlend": Augmentation.from_node("AugImgBlendExp", blendFactor=0.5),
    "MotionBlur": Augmentation.from_node("AugMotionBlurExp", motionAngle=45.0, strength=0.7, kernelSize=11),
    "Pixellate": Augmentation.from_node("AugPixellateExp", kernelSize=8),
    "Rotate": Augmentation.from_node("AugRotateExp", rotation=45.0),
    "Canny": Augmentation.from_node("AugCanny", thresholdLow=50.0, thresholdHigh=100.0),
}
for _name, _augmentation in _FUNCTIONS.items():
    augmentations.add(_name, _augmentation)

# Names of the functions and nodes that implement some of them.
_ALIASES = {
    "adjust_sigmoid": "AdjustSigmoid",
    "brightness": "Brightness",
    "speckle_noise": "SpeckleNoise",
    "shot_noise": "ShotNoise",
    "rgb_to_hsv": "RgbToHsv",
    "hsv_to_rgb": "HsvToRgb",
    "glass_blur": "GlassBlur",
    "BgRand": "BackgroundRand",
    "ImgBlend": "ImageBlend",
}
for _name, _of in _ALIASES.items():
    augmentations.add(_name, _FUNCTIONS[_of])

DEFAULT_AUGMENTATIONS = (*_FUNCTIONS, *_ALIASES)
