"""Interpolated transforms, against Gf's own slerp."""

import numpy as np
from pxr import Gf

from usdsdg_render.sync.rigid_motion import RigidMotion


def pose(axis, degrees, translate, scale=1.0):
    rotation = Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(*axis), degrees))
    return np.array(Gf.Matrix4d().SetScale(scale) * rotation * Gf.Matrix4d().SetTranslate(Gf.Vec3d(*translate)))


def test_both_ends_are_given_back():
    before, after = pose((1, 2, 3), 40, (0, 1, 2), 0.3)[None], pose((0, 1, -1), 110, (2, 0, 1), 0.3)[None]
    np.testing.assert_allclose(RigidMotion(before, after).at(0.0), before, atol=1e-12)
    np.testing.assert_allclose(RigidMotion(before, after).at(1.0), after, atol=1e-12)


def test_rotation_is_spherical_and_translation_straight():
    first, second = Gf.Rotation(Gf.Vec3d(1, 2, 3), 40), Gf.Rotation(Gf.Vec3d(0, 1, -1), 110)
    before = np.array([pose((1, 2, 3), 40, (0, 1, 2), 0.3)])
    after = np.array([pose((0, 1, -1), 110, (2, 0, 1), 0.3)])
    for fraction in (0.2, 0.5, 0.9):
        quaternion = Gf.Slerp(fraction, first.GetQuaternion(), second.GetQuaternion())
        expected = Gf.Matrix4d().SetScale(0.3) * Gf.Matrix4d().SetRotate(Gf.Rotation(quaternion))
        mixed = RigidMotion(before, after).at(fraction)[0]
        np.testing.assert_allclose(mixed[:3, :3], np.array(expected)[:3, :3], atol=1e-9)
        np.testing.assert_allclose(mixed[3, :3], [2 * fraction, 1 - fraction, 2 - fraction], atol=1e-12)


def test_a_spinning_thing_keeps_its_size_halfway():
    before, after = pose((0, 0, 1), 0, (0, 0, 0))[None], pose((0, 0, 1), 170, (0, 0, 0))[None]
    assert np.isclose(np.linalg.det(RigidMotion(before, after).at(0.5)[0, :3, :3]), 1.0)


def test_a_scale_that_changes_is_blended():
    before, after = pose((0, 0, 1), 0, (0, 0, 0), 1.0)[None], pose((0, 0, 1), 0, (0, 0, 0), 3.0)[None]
    np.testing.assert_allclose(RigidMotion(before, after).at(0.5)[0, :3, :3], 2 * np.eye(3))


def test_broken_transforms_do_not_spoil_the_others():
    broken = np.full((4, 4), np.nan)
    good = pose((0, 0, 1), 90, (1, 0, 0))
    mixed = RigidMotion(np.array([broken, np.eye(4)]), np.array([broken, good])).at(0.5)
    np.testing.assert_allclose(mixed[1], pose((0, 0, 1), 45, (0.5, 0, 0)), atol=1e-12)
