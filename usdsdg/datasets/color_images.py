"""Color images of datasets: those that labels lie over."""

from usdsdg.datasets.folder import Folder
from usdsdg.datasets.seen import Color, Seen


def read_color(folder: Folder, seen: Seen, file: str) -> None:
    """Add a color image to what is seen of an image, unless it is broken, which is a fault of the folder."""
    if (image := folder.image(file, seen.name)) is not None:
        seen.colors.append(Color(file, image, exact=file.lower().endswith(".png")))
