"""Scripts that take colors of segmentation for packed, whatever they import."""

from __future__ import annotations

import ast


def reads_packed_colors(tree: ast.AST) -> bool:
    """Return whether a script gives an array of bytes the shape `*data.shape, -1`.

    That makes (H, W, 4) of packed colors, as Isaac Sim 4 has them. Of later ones it would make (H, W, 4, 1), which is
    no picture, so the script was written for the former.
    """
    return any(
        isinstance(node, ast.Call)
        and isinstance(node.func, ast.Attribute)
        and node.func.attr == "reshape"
        and _is_of_bytes(node.func.value)
        and _has_one_more_axis(node.args)
        for node in ast.walk(tree)
    )


def _is_of_bytes(array: ast.AST) -> bool:
    """Whether the expression is a call of `frombuffer` or `view` for uint8."""
    return (
        isinstance(array, ast.Call)
        and isinstance(array.func, ast.Attribute)
        and array.func.attr in ("frombuffer", "view")
        and any(
            isinstance(each, ast.Attribute) and each.attr == "uint8"
            for each in [*array.args, *(keyword.value for keyword in array.keywords)]
        )
    )


def _has_one_more_axis(shape: list[ast.expr]) -> bool:
    match shape:
        case [ast.Starred(ast.Attribute(attr="shape")), ast.UnaryOp(ast.USub(), ast.Constant(1))]:
            return True
        case _:
            return False
