"""Prim paths: validation, free paths and look-up."""

import difflib
import itertools
import re

from pxr import Sdf, Tf, Usd, UsdGeom

from usdsdg.errors import BadPrim

_NUMBER = re.compile(r"_(\d+)$")
# Most paths: those that need no search for what is wrong with them, which takes ten times as long.
_PLAIN = re.compile(r"(?:/[A-Za-z_][A-Za-z0-9_]*)+")


def next_free_path(stage: Usd.Stage, path: str | Sdf.Path, prepend_default_prim: bool = False) -> str:
    """Return `path` if no prim has it, else the first free of path_01, path_02, ...; a trailing number is incremented.

    Raises:
        BadPrim: `path` is not an absolute prim path.
    """
    wanted = prim_path(path)
    root = stage.GetDefaultPrim()
    if prepend_default_prim and root and not wanted.HasPrefix(root.GetPath()):
        wanted = root.GetPath().AppendPath(wanted.MakeRelativePath(Sdf.Path.absoluteRootPath))
    return str(wanted) if not stage.GetPrimAtPath(wanted) else free_paths(stage, wanted, 1)[0]


def free_paths(stage: Usd.Stage, path: str | Sdf.Path, count: int) -> list[str]:
    """Return the paths that `next_free_path` gives to `count` prims made one after the other.

    Raises:
        BadPrim: `path` is not an absolute prim path.
    """
    wanted = prim_path(path)
    parent = stage.GetPrimAtPath(wanted.GetParentPath())
    # One list of names instead of one look-up per number: scenes have thousands of siblings.
    taken = set(parent.GetAllChildrenNames()) if parent else set()
    number = _NUMBER.search(wanted.name)
    stem, first = (wanted.name[: number.start()], int(number.group(1))) if number else (wanted.name, 0)
    numbered = (f"{stem}_{k:02d}" for k in itertools.count(first + 1))
    free = (name for name in itertools.chain([wanted.name], numbered) if name not in taken)
    folder = str(wanted)[: -len(wanted.name)]
    return [f"{folder}{name}" for name in itertools.islice(free, count)]


def prim_path(path: str | Sdf.Path) -> Sdf.Path:
    """Convert `path` to an absolute Sdf.Path of a prim.

    Raises:
        BadPrim: it is relative, names a property, or has characters that USD does not allow in a name.
    """
    if isinstance(path, Sdf.Path) and path.IsAbsoluteRootOrPrimPath() and path.IsAbsolutePath():
        return path
    text = str(path)
    if _PLAIN.fullmatch(text):
        return Sdf.Path(text)
    valid, why = Sdf.Path.IsValidPathString(text)
    if not valid or not text:
        if "*" in text:
            pattern = f"^{text.replace('*', '[^/]*')}$"
            raise BadPrim(
                f"{text!r} is not the path of one prim; rep.get.prims(path_pattern={pattern!r}) finds those that match."
            )
        suggestion = "/" + "/".join(valid_name(part) for part in text.split("/") if part)
        raise BadPrim(f"{text!r} is not a prim path ({why or 'it is empty'}). Try {suggestion!r}.")
    result = Sdf.Path(text)
    if not result.IsAbsoluteRootOrPrimPath() or not result.IsAbsolutePath():
        raise BadPrim(f"{text!r} is not the absolute path of a prim; it should look like '/World/name'.")
    return result


def at_or_below(path: str, root: str) -> bool:
    """Return whether a path is `root` or below it."""
    return path == root or path.startswith(root + "/")


def valid_name(text: str) -> str:
    """Replace every character that a prim name cannot have by an underscore."""
    return Tf.MakeValidIdentifier(text)


def check_parent(prim: Usd.Prim) -> None:
    """Check that prims can be created below a prim.

    Raises:
        BadPrim: it is a shape or a light.
    """
    if prim.IsA(UsdGeom.Boundable):
        raise BadPrim(
            f"{prim.GetPath()} is a {prim.GetTypeName()}, and USD does not allow prims below shapes and lights; "
            "create them below an Xform or Scope"
        )


def prim_at(stage: Usd.Stage, path: str | Sdf.Path) -> Usd.Prim:
    """Return the prim at `path`.

    Raises:
        BadPrim: there is none; the message names the deepest existing ancestor, its children, and similar names.
    """
    wanted = prim_path(path)
    if prim := stage.GetPrimAtPath(wanted):
        return prim
    ancestor = wanted.GetParentPath()
    while not stage.GetPrimAtPath(ancestor):
        ancestor = ancestor.GetParentPath()
    names = stage.GetPrimAtPath(ancestor).GetAllChildrenNames()
    missing = wanted.GetPrefixes()[ancestor.pathElementCount].name
    near = [str(ancestor.AppendChild(name)) for name in difflib.get_close_matches(missing, names, 3, 0.6)]
    hint = f" (did you mean {' or '.join(near)}?)" if near else ""
    listing = ", ".join(names[:12]) + (", ..." if len(names) > 12 else "") if names else "nothing"
    raise BadPrim(f"there is no prim {wanted} on the stage; {ancestor} has {listing} below it{hint}")
