"""Order joints to trees that start at the world, at a kinematic body or at a floating base; the others close loops."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from operator import eq

from usdsdg_physics.scene.records import STATIC, Axis, Body, Joint

# Joints of these kinds can close a loop, though only their frames are held together: without limits and drive.
LOOP_KINDS = frozenset({"fixed", "revolute", "ball", "weld"})
FREE_AXES = 6


@dataclass(frozen=True)
class Branch:
    """A joint of a tree, from the body that is nearer to the root (or STATIC) to the other."""

    joint: Joint
    parent: str
    child: str

    @property
    def is_reversed(self) -> bool:
        """Whether the joint's body 1 is the parent."""
        return self.child == self.joint.body0 and self.parent == self.joint.body1


@dataclass
class JointTree:
    """Bodies that joints connect, parents before children."""

    root: str  # path of a floating or kinematic base; STATIC where every branch starts at the world
    branches: list[Branch] = field(default_factory=list)
    loops: list[Branch] = field(default_factory=list)
    # Would connect it to the tree of another kinematic body, which the solver cannot.
    unclosed: list[Joint] = field(default_factory=list)

    @property
    def bodies(self) -> list[str]:
        """The bodies of the tree, its base included."""
        return [self.root] * bool(self.root) + [branch.child for branch in self.branches]


def joint_trees(bodies: Mapping[str, Body], joints: Collection[Joint]) -> list[JointTree]:
    """Return the trees of all bodies that joints connect.

    Joints between kinematic bodies and the world are left out, those that hold nothing, and distance joints, which
    connect as contacts do.
    What can close no loop is put into the tree before the rest, and what is in an articulation before what is not.
    """
    fixed = {STATIC} | {path for path, body in bodies.items() if body.kinematic}
    used = [
        joint
        for joint in joints
        if joint.kind != "distance" and not is_loose(joint) and not (joint.body0 in fixed and joint.body1 in fixed)
    ]
    # Of two ways to the world the second closes a loop: a tree starts there once.
    chosen, closing = _spanning(sorted(used, key=lambda j: (*_rank(j), j.body0 in fixed or j.body1 in fixed)), fixed)
    order = {joint.path: index for index, joint in enumerate(used)}
    chosen.sort(key=lambda joint: order[joint.path])
    trees = _grow(chosen, fixed, [path for path, body in bodies.items() if body.is_articulation_root])
    tree_of = {path: tree for tree in trees for path in tree.bodies if path not in fixed}
    for joint in sorted(closing, key=lambda joint: order[joint.path]):
        parent, child = (joint.body0, joint.body1) if joint.body1 not in fixed else (joint.body1, joint.body0)
        if parent not in fixed and not _connect(trees, tree_of, parent, child):
            tree_of[child].unclosed.append(joint)
        else:
            tree_of[child].loops.append(Branch(joint, parent, child))
    moved = {joint.path: body for joint in used for body in (joint.body0, joint.body1) if body in tree_of}
    for joint in used:
        # Those that follow each other are in one tree.
        if joint.mimic is not None and joint.path in moved and joint.mimic.leader in moved:
            _connect(trees, tree_of, moved[joint.mimic.leader], moved[joint.path])
    return trees


def _connect(trees: list[JointTree], tree_of: dict[str, JointTree], first: str, second: str) -> bool:
    """Make one tree of those of two bodies, which both start at the world, or one of them at a kinematic body.

    Return whether they are in one tree now.
    """
    kept, other = tree_of[first], tree_of[second]
    if kept is other:
        return True
    if kept.root == STATIC and other.root != STATIC:
        kept, other = other, kept
    if other.root != STATIC:
        return False
    kept.branches += other.branches
    kept.loops += other.loops
    kept.unclosed += other.unclosed
    tree_of |= dict.fromkeys(other.bodies, kept)
    trees.remove(other)
    return True


def unsupported_loops(trees: Collection[JointTree]) -> list[Joint]:
    """Return the joints that would have to close a loop, and cannot."""
    return [joint for tree in trees for joint in tree.unclosed]


def connected_bodies(joints: Collection[Joint], start: Collection[str], bodies: Mapping[str, Body]) -> set[str]:
    """Return the dynamic bodies that joints connect to bodies `start`, and those themselves."""
    neighbors: defaultdict[str, set[str]] = defaultdict(set)
    for joint in joints:
        if joint.kind == "distance":
            continue  # What hangs on a rope may swing.
        neighbors[joint.body0].add(joint.body1)
        neighbors[joint.body1].add(joint.body0)
    found, left = set(), list(start)
    while left:
        body = left.pop()
        if body in found or body not in bodies or bodies[body].kinematic:
            continue
        found.add(body)
        left.extend(neighbors[body])
    return found


def is_moved(joint: Joint) -> bool:
    """Return whether an axis of a joint has limits or a drive."""
    return any(axis.drive or axis.lower > float("-inf") or axis.upper < float("inf") for axis in joint.axes)


def is_loose(joint: Joint) -> bool:
    """Return whether a joint holds nothing: all of its six axes are free."""
    free = (Axis(axis.name, axis.angular, axis.direction, instance=axis.instance) for axis in joint.axes)
    return len(joint.axes) == FREE_AXES and all(map(eq, joint.axes, free))


def _rank(joint: Joint) -> tuple[bool, bool, bool, bool]:
    fixes = is_moved(joint) or joint.kind == "fixed"
    return joint.kind == "weld", joint.kind in LOOP_KINDS, not joint.in_articulation, not fixes


def _spanning(joints: list[Joint], fixed: Collection[str]) -> tuple[list[Joint], list[Joint]]:
    """Split joints into those that connect bodies for the first time and those that close loops.

    The world and all kinematic bodies count as one, so that no tree has two of them.
    """
    leader: dict[str, str] = {}

    def find(body: str) -> str:
        body = STATIC if body in fixed else body
        while leader.setdefault(body, body) != body:
            body = leader[body]
        return body

    chosen, closing = [], []
    for joint in joints:
        first, second = find(joint.body0), find(joint.body1)
        (closing if first == second else chosen).append(joint)
        leader[second] = first
    return chosen, closing


def _grow(joints: list[Joint], fixed: Collection[str], roots: Collection[str]) -> list[JointTree]:
    """Return the trees of joints without loops, breadth first."""
    at: defaultdict[str, list[Joint]] = defaultdict(list)
    for joint in joints:
        at[joint.body0].append(joint)
        at[joint.body1].append(joint)
    trees, reached = [], set(fixed)
    # From the world each branch is a tree of its own, from a kinematic body all are one.
    for joint in at[STATIC]:
        child = joint.body1 if joint.body0 == STATIC else joint.body0
        trees.append(JointTree(STATIC, [Branch(joint, STATIC, child)]))
        reached.add(child)
    trees += [JointTree(path) for path in at if path in fixed and path != STATIC]
    for tree in trees:
        _extend(tree, at, reached)
    for path in _bases(joints, roots):
        if path not in reached:
            reached.add(path)
            trees.append(JointTree(path))
            _extend(trees[-1], at, reached)
    return trees


def _extend(tree: JointTree, at: Mapping[str, list[Joint]], reached: set[str]) -> None:
    level = tree.bodies
    while level:
        following = []
        for body in level:
            for joint in at[body]:
                other = joint.body1 if joint.body0 == body else joint.body0
                if other not in reached:
                    reached.add(other)
                    tree.branches.append(Branch(joint, body, other))
                    following.append(other)
        level = following


def _bases(joints: list[Joint], roots: Collection[str]) -> list[str]:
    """Return all bodies, roots of articulations first, then those that are no joint's body 1."""
    children = {joint.body1 for joint in joints}
    paths = dict.fromkeys(path for joint in joints for path in (joint.body0, joint.body1))
    return sorted(paths, key=lambda path: (path not in roots, path in children))
