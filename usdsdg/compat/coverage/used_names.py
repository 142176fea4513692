"""Read which foreign names scripts use, with their lines, without running them."""

import ast
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from usdsdg.arguments.registry import near_misses
from usdsdg.compat import finder
from usdsdg.errors import ConfigError

ROOTS = (*finder.ROOTS, *finder.WEAK_ROOTS)
# Of `pxr`, the modules that usd-core does not have.
PXR = ("PhysxSchema", "PhysicsSchemaTools", "Semantics")
# Functions whose first argument is the name of a member of a registry.
REGISTRIES = {
    "annotators.get": "annotators.get",
    "AnnotatorRegistry.get_annotator": "annotators.get",
    "writers.get": "writers.get",
    "WriterRegistry.get": "writers.get",
}
CORE = ("omni.replicator.core.scripts.", "omni.replicator.core.")
# Functions that return the one object of a class, whose members are looked up in the class.
GETTERS = {
    "omni.usd.get_context": "omni.usd.UsdContext",
    "omni.timeline.get_timeline_interface": "omni.timeline.ITimeline",
    "omni.timeline.acquire_timeline_interface": "omni.timeline.ITimeline",
    "omni.kit.app.get_app": "omni.kit.app.IApp",
    "omni.kit.app.get_app_interface": "omni.kit.app.IApp",
    "carb.settings.get_settings": "carb.settings.ISettings",
    "carb.settings.get_settings_interface": "carb.settings.ISettings",
    "carb.settings.acquire_settings_interface": "carb.settings.ISettings",
    "carb.dictionary.get_dictionary": "carb.dictionary.IDictionary",
}
_RANDOMIZERS = tuple(f"{core}randomizer." for core in CORE)
# To these a script can add members.
_OPEN = (*CORE, "annotators.get", "writers.get")

_OBJECTS = frozenset(GETTERS.values())


@dataclass(frozen=True, order=True)
class Use:
    """One use of a foreign name: `omni.usd.get_context`, or a member of a registry: `annotators.get('rgb')`.

    near: of a randomizer, a similar name that the scripts define, which they may have registered and meant; or "".
    """

    name: str
    file: str
    line: int
    column: int = 0
    called: bool = False
    near: str = ""

    def or_near(self, why: str) -> str:
        """Add to the reason why the name is missing which name of the script may be meant."""
        return f"{why}; or did you mean {self.near}, which the script defines?" if self.near else why


def uses_of(scripts: Sequence[Path], unread: dict[Path, ConfigError] | None = None) -> list[Use]:
    """Return the foreign names that scripts use, also in the modules beside them that they import.

    Aliases are resolved: after `import omni.usd as u`, `u.get_context()` uses `omni.usd.get_context`. Of what functions
    return, members are seen where it is one of `GETTERS`: `u.get_context().get_stage()`, or `self.context.get_stage()`
    after `self.context = u.get_context()`, use `omni.usd.UsdContext.get_stage`. Members that the scripts register
    themselves are not seen.

    unread: gets the files that cannot be read, or are not Python, with their errors; None: the first one is raised.

    Raises:
        ConfigError: a file cannot be read, or is not Python.
    """
    queue = [(path, path.parent) for path in scripts]
    seen: set[Path] = set()
    uses: set[Use] = set()
    own: set[str] = set()
    for path, folder in queue:
        if path.resolve() in seen:
            continue
        seen.add(path.resolve())
        reader = _Reader(str(path), (folder, path.parent, *map(Path, sys.path)))
        try:
            tree = _parsed(path)
        except ConfigError as error:
            if unread is None:
                raise
            unread[path] = error
            continue
        reader.visit(tree)
        uses |= reader.uses
        own |= reader.definitions
        queue += [(helper, folder) for name in reader.imported for helper in _helpers(folder, path.parent, name)]
    return sorted(_beside(use, own) for use in uses if not (use.name.startswith(_OPEN) and _last(use.name) in own))


def _beside(use: Use, own: set[str]) -> Use:
    if not use.name.startswith(_RANDOMIZERS):
        return use
    return replace(use, near=next(iter(near_misses(_last(use.name), sorted(own), count=1)), ""))


def _last(name: str) -> str:
    return name.removesuffix("')").replace("('", ".").rpartition(".")[2]


def _parsed(path: Path) -> ast.Module:
    try:
        return ast.parse(path.read_bytes(), str(path))
    except (OSError, UnicodeDecodeError, ValueError) as error:
        raise ConfigError(f"{path} cannot be read: {error}") from None
    except SyntaxError as error:
        raise ConfigError(f"{path}, line {error.lineno}: not Python: {error.msg}") from None


def _helpers(folder: Path, beside: Path, name: str) -> Iterator[Path]:
    """Yield the files of a module `name`, and of packages above it, beside the first script or this file."""
    parts = name.split(".")
    for base in dict.fromkeys((folder, beside)):
        for end in range(1, len(parts) + 1):
            module = base.joinpath(*parts[:end])
            yield from (file for file in (module.with_suffix(".py"), module / "__init__.py") if file.is_file())


class _Reader(ast.NodeVisitor):
    """Collects the uses, the other imports and the definitions of one file."""

    def __init__(self, file: str, folders: Sequence[Path]) -> None:
        self._file = file
        self._folders = {root: [base for base in folders if (base / root).is_dir()] for root in ROOTS}
        self._aliases: dict[str, str] = {}
        self._called: set[ast.AST] = set()
        self.uses: set[Use] = set()
        self.imported: set[str] = set()
        self.definitions: set[str] = set()

    def visit_Import(self, node: ast.Import) -> None:
        for each in node.names:
            if self._is_foreign(each.name):
                first = each.name.partition(".")[0]
                self._aliases[each.asname or first] = each.name if each.asname else first
                self._use(each.name, node)
            else:
                self.imported.add(each.name)

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        module = node.module or ""
        for each in node.names:
            name = module if each.name == "*" else f"{module}.{each.name}"
            if node.level == 0 and self._is_foreign(name):
                self._aliases[each.asname or each.name] = name
                self._use(name, node)
            else:
                self.imported.update((module, name.lstrip(".")) if module else (each.name,))

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        self.definitions.add(node.name)
        self.generic_visit(node)

    def visit_FunctionDef(self, node: ast.FunctionDef | ast.AsyncFunctionDef) -> None:
        self.definitions.add(node.name)
        outside = dict(self._aliases)
        for parameter in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs):
            self._aliases.pop(parameter.arg, None)
        self.generic_visit(node)
        # Objects in variables of a function are not those of other functions; modules that it imports may be.
        inside = {name: of for name, of in self._aliases.items() if "." in name or of not in _OBJECTS}
        self._aliases = {**inside, **outside}

    visit_AsyncFunctionDef = visit_FunctionDef

    def visit_keyword(self, node: ast.keyword) -> None:
        # `rep.randomizer.register(function, fn_name="name")`
        if node.arg in ("fn_name", "name") and isinstance(node.value, ast.Constant):
            self.definitions.add(str(node.value.value))
        self.generic_visit(node)

    def visit_Assign(self, node: ast.Assign) -> None:
        name = self._resolved(node.value)
        for target in map(_dotted, node.targets):
            if target is None or (name not in _OBJECTS and "." in target):
                continue
            if self._aliases.get(target) in _OBJECTS:
                del self._aliases[target]
            if name is not None:
                self._aliases.setdefault(target, name)
        self.generic_visit(node)

    def visit_Attribute(self, node: ast.Attribute) -> None:
        name = self._resolved(node)
        if isinstance(node.ctx, ast.Store):
            self.definitions.add(node.attr)
        elif name is None:
            self.generic_visit(node)
        else:
            self._use(name, node)
            if isinstance(root := _root(node), ast.Call):
                self.visit(root)

    def visit_Call(self, node: ast.Call) -> None:
        name = self._resolved(node.func)
        self._called.add(node.func)
        if name is not None and isinstance(node.func, ast.Name):
            self._use(name, node.func)
        if name is not None and name.startswith(CORE) and node.args and isinstance(node.args[0], ast.Constant):
            below = next(name.removeprefix(core) for core in CORE if name.startswith(core))
            given = node.args[0].value
            if below in REGISTRIES and isinstance(given, str):
                self._called.add(node)
                self._use(f"{REGISTRIES[below]}('{given}')", node)
            elif below.rpartition(".")[2].startswith("register"):
                self.definitions.add(str(given))  # `rep.annotators.register("name", annotator)`
        self.generic_visit(node)

    def _resolved(self, node: ast.AST) -> str | None:
        """Return the foreign name that a chain of attributes stands for; None for anything else."""
        parts: list[str] = []
        while (alias := self._aliases.get(_dotted(node) or "")) is None and isinstance(node, ast.Attribute):
            parts.insert(0, node.attr)
            node = node.value
        if isinstance(node, ast.Call):
            alias = GETTERS.get(self._resolved(node.func) or "")
        return None if alias is None else ".".join([alias, *parts])

    def _is_foreign(self, name: str) -> bool:
        """Whether a name is of Omniverse, and not of a package of the script's own, as `omni.mine` of an extension."""
        parts = name.split(".")
        if parts[0] not in ROOTS:
            return parts[0] == "pxr" and len(parts) > 1 and parts[1] in PXR
        ends = range(2, len(parts) + 1)
        modules = (base.joinpath(*parts[:end]) for base in self._folders[parts[0]] for end in ends)
        return not any(module.with_suffix(".py").is_file() or (module / "__init__.py").is_file() for module in modules)

    def _use(self, name: str, node: ast.AST) -> None:
        if not self._is_foreign(name.partition("(")[0]) and name.partition(".")[0] in ROOTS:
            return
        place = getattr(node, "lineno", 0), getattr(node, "col_offset", 0)
        self.uses.add(Use(name, self._file, *place, called=node in self._called))


def _root(node: ast.AST) -> ast.AST:
    """Return what a chain of attributes starts from."""
    while isinstance(node, ast.Attribute):
        node = node.value
    return node


def _dotted(node: ast.AST) -> str | None:
    """Return the text of a name or a chain of attributes of a name; None for anything else."""
    root = _root(node)
    return ast.unparse(node) if isinstance(root, ast.Name) else None
