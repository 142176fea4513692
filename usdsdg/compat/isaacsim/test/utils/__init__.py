"""`isaacsim.test.utils`: what Isaac Sim's examples check and save their pictures and files with."""

from usdsdg.compat.isaacsim.test.utils.file_validation import get_folder_file_summary, validate_folder_contents
from usdsdg.compat.isaacsim.test.utils.image_io import read_image_as_array, save_depth_image, save_rgb_image

__all__ = [
    "get_folder_file_summary",
    "read_image_as_array",
    "save_depth_image",
    "save_rgb_image",
    "validate_folder_contents",
]
