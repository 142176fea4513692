"""Which parts of a script are sure to run when it runs to its end, as far as its text tells."""

import ast
from collections.abc import Callable, Iterator

# What these branch on may not happen, and a dictionary may be a choice, or a default that is overridden.
UNCERTAIN = (ast.If, ast.IfExp, ast.Try, ast.Match, ast.Dict, ast.Lambda, ast.Compare, ast.BoolOp, ast.arguments)


def certain(node: ast.AST, *, skip: Callable[[ast.AST], bool] = lambda _: False) -> Iterator[ast.AST]:
    """Yield a node and all below it, without branches, dictionaries, defaults, and what `skip` leaves out.

    Functions count as sure to be called.
    """
    yield node
    for child in ast.iter_child_nodes(node):
        if not (isinstance(child, UNCERTAIN) or skip(child)):
            yield from certain(child, skip=skip)
