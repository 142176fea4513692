"""What every extracted scene must keep."""

import numpy as np


def assert_sound(scene, checked=None):
    """What the kernels rely on, whatever the stage says. Prototypes in `checked`, by id, are not checked again."""
    checked = {} if checked is None else checked
    assert np.isfinite(scene.instances.local_to_world).all()
    assert len(scene.instances.prototype) == len(scene.instances.slot_offset) == len(scene.instances)
    for prototype in scene.prototypes:
        if id(prototype) in checked:
            continue
        checked[id(prototype)] = prototype
        count = len(prototype.triangles)
        assert count > 0
        assert prototype.triangles.min() >= 0
        assert prototype.triangles.max() < len(prototype.points)
        assert prototype.normals.shape == (count, 3, 3)
        assert prototype.uvs.shape == (count, 3, 2)
        assert prototype.triangle_slots.shape == prototype.triangle_faces.shape == (count,)
        np.testing.assert_allclose(np.linalg.norm(prototype.normals, axis=-1), 1.0, atol=1e-5)
        for name in ("points", "uvs"):
            assert np.isfinite(getattr(prototype, name)).all()
        a, b, c = prototype.points[prototype.triangles].astype(np.float64).transpose(1, 0, 2)
        assert (np.linalg.norm(np.cross(b - a, c - a), axis=1) > 0).all()
    for k, offset in zip(scene.instances.prototype, scene.instances.slot_offset):
        last = offset + scene.prototypes[k].triangle_slots.max()
        assert scene.material_slots[offset : last + 1].max() < len(scene.materials)
    for name in scene.materials.dtype.names:
        column = scene.materials[name]
        assert np.isfinite(column).all()
        if name.endswith("_texture"):
            assert column.max(initial=-1) < len(scene.textures)
    for name in scene.lights.dtype.names:
        assert np.isfinite(scene.lights[name]).all()
    assert (scene.lights["power"] > 0).all()
    if scene.dome is not None:
        assert np.isfinite(scene.dome.radiance).all()
        np.testing.assert_allclose(scene.dome.dome_from_world @ scene.dome.dome_from_world.T, np.eye(3), atol=1e-5)
    for texture in scene.textures:
        assert texture.texels.dtype == np.uint8
        assert texture.texels.ndim == 3
        assert texture.texels.shape[2] == 4
