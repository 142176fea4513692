"""Cut loops of joints through bodies, where a joint that closes one has an axis that the solver has to know."""

from __future__ import annotations

from dataclasses import replace

from usdsdg_physics.scene.joint_trees import LOOP_KINDS, Branch, JointTree, is_moved, joint_trees
from usdsdg_physics.scene.records import Joint, Scene


def cut_loops(scene: Scene) -> Scene:
    """Return a scene whose loops are closed by joints without coordinates only.

    The solver closes loops with fixed, revolute and spherical joints that have no limits, drive or friction, follow no
    other joint and do not break. Any other joint that closes one moves half of its second body instead: one of half the
    mass and without colliders, which a weld holds to the rest of the body. So the joint is one of the tree, and nothing
    of it is lost.
    """
    trees = joint_trees(scene.bodies, scene.joints.values()) if scene.joints else []
    cuts = [branch for tree in trees for branch in tree.loops if _needs_cut(branch, tree)]
    if not cuts:
        return scene
    bodies, joints, halves = dict(scene.bodies), dict(scene.joints), dict(scene.halves)
    for branch in cuts:
        joint, body = branch.joint, branch.child
        half = f"{body} half of {joint.path}"
        halves[half] = body
        bodies[half] = replace(bodies[body], path=half)
        joints[joint.path] = replace(joint, body1=half) if joint.body1 == body else replace(joint, body0=half)
        weld = f"{joint.path} weld"
        same = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
        joints[weld] = Joint(weld, "weld", body, half, same, same)
    return replace(scene, bodies=bodies, joints=joints, halves=halves)


def _needs_cut(branch: Branch, tree: JointTree) -> bool:
    joint = branch.joint
    if joint.kind not in LOOP_KINDS:
        return True
    if joint.mimic is not None or joint.breaks or _rubs(joint):
        return True
    # The second hinge of a door has the limits of the first.
    ends = {branch.parent, branch.child}
    beside = any({other.parent, other.child} == ends for other in tree.branches)
    return is_moved(joint) and not beside


def _rubs(joint: Joint) -> bool:
    return any(axis.static_friction or axis.friction or axis.damping or axis.armature for axis in joint.axes)
