"""Single pictures of the viewport: they show the stage as it is when they are asked for."""

import asyncio
import ctypes

import numpy as np
import pytest
from PIL import Image
from pxr import UsdGeom

from usdsdg import create
from usdsdg.app.app import get_app
from usdsdg.compat.omni.kit.viewport import utility
from usdsdg.errors import Unsupported
from usdsdg.session.stage_context import current_stage, new_stage


@pytest.fixture
def viewport():
    new_stage()
    stage = current_stage()
    create.light(light_type="dome")
    UsdGeom.Cube.Define(stage, "/World/Box").GetSizeAttr().Set(0.5)
    eye = UsdGeom.Camera.Define(stage, "/World/Eye")
    UsdGeom.XformCommonAPI(eye).SetTranslate((0, 0, 5))
    found = utility.get_active_viewport()
    found.camera_path, found.resolution = "/World/Eye", (64, 48)
    return found


def test_a_file_shows_the_stage_of_its_moment(viewport, tmp_path):
    utility.capture_viewport_to_file(viewport, str(tmp_path / "new" / "first.png"))
    UsdGeom.XformCommonAPI(current_stage().GetPrimAtPath("/World/Box")).SetTranslate((0, 0, -300))
    utility.capture_viewport_to_file(viewport, file_path=str(tmp_path / "second.png"))
    first, second = (np.array(Image.open(tmp_path / name)) for name in ("new/first.png", "second.png"))
    assert first.shape == (48, 64, 4)
    assert (first[24, 32] != second[24, 32]).any()
    assert (first[2, 2] == second[2, 2]).all()


def test_a_buffer_is_a_capsule_with_the_pixels_of_the_file(viewport, tmp_path):
    seen = []

    def take(buffer, size, width, height, form):
        pointer = ctypes.pythonapi.PyCapsule_GetPointer
        pointer.restype, pointer.argtypes = ctypes.POINTER(ctypes.c_byte * size), [ctypes.py_object, ctypes.c_char_p]
        content = bytes(pointer(buffer, None).contents)
        seen.append((np.frombuffer(content, np.uint8).reshape(height, width, 4), str(form)))

    async def capture():
        await viewport.wait_for_rendered_frames()
        await utility.next_viewport_frame_async(viewport, 1)
        done = utility.capture_viewport_to_buffer(viewport, take)
        return await done.wait_for_result()

    before = get_app().get_update_number()
    assert asyncio.run(capture())
    assert get_app().get_update_number() >= before
    utility.capture_viewport_to_file(viewport, str(tmp_path / "same.png"))
    (image, form), written = seen[0], np.array(Image.open(tmp_path / "same.png"))
    assert form == "TextureFormat.RGBA8_UNORM"
    # The samples of another moment differ, not what is seen.
    assert np.abs(image.astype(float) - written).mean() < 1
    assert (image[2, 2] == written[2, 2]).all()


def test_what_a_capture_cannot_do_says_what_can(viewport, tmp_path):
    with pytest.raises(Unsupported, match="annotator HdrColor"):
        utility.capture_viewport_to_file(viewport, str(tmp_path / "a.exr"), is_hdr=True)
    with pytest.raises(Unsupported, match=r"viewport\.render_product_path = '/Render/Other'"):
        utility.capture_viewport_to_buffer(viewport, print, render_product_path="/Render/Other")
    with pytest.raises(Unsupported, match="use capture_viewport_to_file"):
        viewport.schedule_capture(None)
