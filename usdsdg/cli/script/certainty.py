"""Which parts of a script are sure to run when it runs to its end, as far as its text tells."""

import ast
from collections.abc import Callable, Iterator

# What these branch on may not happen, and a dictionary may be a choice, or a default that is overridden.
UNCERTAIN = (ast.If, ast.IfExp, ast.Try, ast.Match, ast.Dict, ast.Lambda, ast.Compare, ast.BoolOp, ast.arguments)
_DEFINITIONS = (ast.FunctionDef, ast.AsyncFunctionDef)


def certain(node: ast.AST, *, skip: Callable[[ast.AST], bool] = lambda _: False) -> Iterator[ast.AST]:
    """Yield a node and all below it, without branches, dictionaries, defaults, and what `skip` leaves out.

    Functions count as sure to be called.
    """
    yield node
    for child in ast.iter_child_nodes(node):
        if (_is_main_guard(child) or not isinstance(child, UNCERTAIN)) and not skip(child):
            yield from certain(child, skip=skip)


def reached(module: ast.Module) -> Iterator[ast.AST]:
    """Yield what `certain` does, with those functions only that the code which is yielded calls by their names."""
    functions = {each.name: each for each in module.body if isinstance(each, _DEFINITIONS)}
    parts: list[ast.AST] = [module]
    for part in parts:
        for node in certain(part, skip=lambda each: _defines(each) or _suppresses(each)):
            yield node
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in functions:
                parts.append(functions.pop(node.func.id))


def _is_main_guard(node: ast.AST) -> bool:
    """Whether a statement is `if __name__ == "__main__":`, which holds for a script that is run."""
    return isinstance(node, ast.If) and ast.unparse(node.test) == "__name__ == '__main__'" and not node.orelse


def _defines(node: ast.AST) -> bool:
    return isinstance(node, (*_DEFINITIONS, ast.ClassDef))


def _suppresses(node: ast.AST) -> bool:
    return isinstance(node, ast.With) and any("suppress" in ast.unparse(item.context_expr) for item in node.items)
