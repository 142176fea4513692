"""BasicWriter's skeletons: joints against the recorded camera and picture; their parents, rotations and occluders."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from usdsdg.datasets.faults import Fault, Faults
from usdsdg.datasets.formats.basic import SKELETONS, Skeletons
from usdsdg.datasets.seen import Seen
from usdsdg.verify.checks.compare import differs, text

# One entry for each joint.
_OF_JOINTS = (
    "skeleton_joints", "skeleton_parents", "rest_global_translations", "rest_local_translations",
    "rest_local_rotations", "global_translations", "local_rotations", "translations_2d", "joint_occlusions",
    "occlusion_types",
)  # fmt: skip
_PIXELS = 0.01
_UNIT = 1e-4  # of the length of quaternions, by float32 in files of animations
_OUT_OF_VIEW, _BACKGROUND, _NOTHING = "OUT_OF_VIEW", "BACKGROUND", "None"


def check(seen: Seen) -> Faults:
    """Compare the skeletons of an image with each other's values and with the recorded camera and pixels."""
    found: Skeletons | None = seen.extra.get(SKELETONS)
    if found is None:
        return
    for skeleton in found.skeletons.values():
        what = f"of {skeleton['skel_path']}"
        lengths = {name: len(skeleton[name]) for name in _OF_JOINTS}
        count = lengths["skeleton_joints"]
        wrong = {name: length for name, length in lengths.items() if length != count}
        if wrong:
            yield Fault(found.file, seen.name, f"there is one value for each joint {what}", str(count), str(wrong))
            continue
        yield from _joints(seen, found.file, skeleton, what)
        yield from _pixels(seen, found.file, skeleton, what)


def _joints(seen: Seen, file: str, skeleton: Mapping[str, Any], what: str) -> Faults:
    """Parents are those that the paths of joints name; rotations have unit length."""
    names = skeleton["skeleton_joints"]
    index = {name: number for number, name in enumerate(names)}
    # A joint whose parents are no joints is a root.
    above = [["/".join(name.split("/")[:end]) for end in range(name.count("/"), 0, -1)] for name in names]
    parents = [next((index[each] for each in prefixes if each in index), -1) for prefixes in above]
    if skeleton["skeleton_parents"] != parents:
        yield Fault(file, seen.name, f"parents of joints {what}", str(parents), str(skeleton["skeleton_parents"]))
    for name in ("local_rotations", "rest_local_rotations"):
        lengths = np.linalg.norm(np.array(skeleton[name], np.float64).reshape(-1, 4), axis=1)
        if differs(lengths, np.ones(len(names)), relative=0.0, absolute=_UNIT):
            yield Fault(file, seen.name, f"{name} {what} are unit quaternions", "", text(lengths))


def _pixels(seen: Seen, file: str, skeleton: Mapping[str, Any], what: str) -> Faults:
    """Joints are where the recorded camera shows them, and are hidden where its picture shows something else."""
    camera = seen.truth.camera if seen.truth is not None else None
    places = np.array(skeleton["global_translations"], np.float64).reshape(-1, 3)
    pixels = np.array(skeleton["translations_2d"], np.float64).reshape(-1, 2)
    if camera is not None and differs(pixels, camera.project(places)[0], relative=1e-6, absolute=_PIXELS):
        yield Fault(file, seen.name, f"joints {what} [pixels]", text(camera.project(places)[0]), text(pixels))
        return
    occluders, hidden = skeleton["occlusion_types"], skeleton["joint_occlusions"]
    if hidden != [occluder != _NOTHING for occluder in occluders]:
        yield Fault(file, seen.name, f"what is occluded {what} has an occluder", str(occluders), str(hidden))
    if camera is None or seen.truth is None:
        return
    with np.errstate(invalid="ignore"):
        inside = np.all((pixels >= 0) & (pixels < (camera.width, camera.height)), axis=1)
    if skeleton["in_view"] is not bool(inside.all()):
        yield Fault(file, seen.name, f"whether all joints {what} are in view", str(inside.all()), skeleton["in_view"])
    gprims = seen.truth.product.gprim_image
    for joint, occluder, pixel, shown in zip(skeleton["skeleton_joints"], occluders, pixels, inside):
        if (occluder == _OUT_OF_VIEW) == shown:
            expected = "in the picture" if shown else _OUT_OF_VIEW
            yield Fault(file, seen.name, f"the joint {joint} {what}", expected, occluder)
        elif shown and gprims is not None:
            is_background = bool(gprims[int(pixel[1]), int(pixel[0])] < 0)
            if (occluder == _BACKGROUND) != is_background:
                expected = _BACKGROUND if is_background else "a surface at its pixel"
                yield Fault(file, seen.name, f"what hides the joint {joint} {what}", expected, occluder)
