"""Convert mesh files and render each, one JSON line in, one out; the soak runs this in a process of its own."""

import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from usdsdg.errors import UsdsdgError
from usdsdg.meshes.conversion import Options, convert

SIZE = (160, 120)


def main() -> int:
    """Answer requests {"file": ..., "folder": ..., "picture": bool} until the input ends."""
    out = sys.stdout
    sys.stdout = sys.stderr
    for line in sys.stdin:
        request = json.loads(line)
        print(
            json.dumps(answer(Path(request["file"]), Path(request["folder"]), request["picture"])), file=out, flush=True
        )
    return 0


def answer(file: Path, folder: Path, picture: bool) -> dict[str, Any]:
    """Return what became of one file; anything but an error of ours ends this process."""
    started = time.perf_counter()
    target = folder / "converted.usdc"
    try:
        report, _ = convert(file, target, Options(label="thing"))
    except UsdsdgError as error:
        return {"refused": str(error), "seconds": time.perf_counter() - started}
    found: dict[str, Any] = {
        "size": report.size, "triangles": report.triangles, "lines": [*report.repairs, *report.notes],
        "seconds": time.perf_counter() - started,
    }  # fmt: skip
    if picture:
        Image.fromarray(rendered(target)).save(folder / "picture.png")
        found["picture"] = str(folder / "picture.png")
    return found


def rendered(stage_file: Path) -> np.ndarray:
    """Render a converted file, (H, W, 3) uint8."""
    import usdsdg as rep
    from usdsdg.session import stage_context
    from usdsdg.stage.cameras import default_view

    stage = stage_context.open_stage(stage_file)
    camera = default_view.add_camera(stage, SIZE[0] / SIZE[1])
    default_view.add_sky(stage)
    rep.settings.set_render_pathtraced(16)
    product = rep.create.render_product(camera, SIZE)
    rgb = rep.AnnotatorRegistry.get_annotator("rgb").attach(product)
    rep.orchestrator.step(delta_time=0.0)
    return np.array(rgb.get_data()[..., :3])


if __name__ == "__main__":
    sys.exit(main())
