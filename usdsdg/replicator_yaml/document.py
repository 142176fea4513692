"""Read a file and the profiles that it inherits from into groups of YAML nodes, which keep their line numbers."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml
from yaml.reader import ReaderError

from usdsdg.arguments.registry import near_misses
from usdsdg.arguments.yaml_bounds import TooLarge, read_bounded
from usdsdg.arguments.yaml_numbers import NumbersLoader
from usdsdg.replicator_yaml.errors import ParserError, fail

Groups = dict[str, yaml.Node]

# Keys of a file that are not groups.
PROFILES, FILE_ROOT, NUCLEUS = "profiles", "file_root_dir", "nucleus_server"
INHERIT = "inherit"

# Extensions whose description files have their name as the only key.
OTHERS = (
    "omni.replicator.object",
    "omni.replicator.agent",
    "isaacsim.replicator.agent",
    "isaacsim.replicator.incident",
)

MAX_PROFILES = 8  # of one file, and in each other


@dataclass
class Document:
    """One file: its groups in order, the groups that are only inherited from, and the base of relative paths."""

    path: Path
    groups: Groups = field(default_factory=dict)  # to be run, from first to last
    templates: Groups = field(default_factory=dict)  # of profiles, and those that other groups inherit from
    file_root: Path = Path()
    nucleus: str | None = None

    def group(self, name: yaml.Node) -> yaml.Node:
        """Return the group that a node names.

        Raises:
            ParserError: there is none; the message suggests similar names.
        """
        known = self.templates | self.groups
        if plain(name) not in known:
            fail(name, f"there is no group {plain(name)!r} to inherit from{hint(str(plain(name)), known)}")
        return known[plain(name)]


def read_document(path: Path, *, root: Path | None, nucleus: str | None, read: tuple[Path, ...] = ()) -> Document:
    """Read a file and its profiles; relative paths are below `root`, else below the file's folder.

    `read`: the files whose profile this one is.

    Raises:
        ParserError: a file cannot be read, is not a mapping of names, has a name twice, or is its own profile.
    """
    groups = _read(path)
    if (extension := next((name for name in OTHERS if name in groups), None)) is not None:
        fail(
            groups[extension],
            f"this describes scenes for the extension {extension}, which is not available. Jobs of `usdsdg generate`, "
            "or Replicator YAML, which calls functions of Replicator, can describe the same",
        )
    read = (*read, path.resolve())
    document = Document(path, file_root=root or path.parent, nucleus=nucleus)
    if (file_root := groups.pop(FILE_ROOT, None)) is not None:
        document.file_root = document.file_root / str(plain(file_root))
    if (server := groups.pop(NUCLEUS, None)) is not None and nucleus is None:
        document.nucleus = str(plain(server))
    profiles = items(groups.pop(PROFILES, None), "profiles")
    if len(profiles) > MAX_PROFILES:
        fail(profiles[0], f"there are more than {MAX_PROFILES} profiles")
    for profile in profiles:
        where = document.file_root / str(plain(profile)).lstrip("/")
        if Path(str(plain(profile))).is_file():
            where = Path(str(plain(profile)))
        if not where.is_file():
            fail(profile, f"there is no profile {where}")
        if where.resolve() in read:
            fail(profile, f"{where} is a profile of itself")
        if len(read) > MAX_PROFILES:
            fail(profile, f"profiles have profiles more than {MAX_PROFILES} deep")
        inner = read_document(where, root=document.file_root, nucleus=nucleus, read=read)
        document.templates |= inner.templates | inner.groups
    try:
        inherited = {name for group in groups.values() for name in _inherited(group)}
    except RecursionError:
        raise ParserError(f"Error parsing {path}: an alias is inside the value that it refers to") from None
    document.templates |= {name: group for name, group in groups.items() if name in inherited}
    document.groups = {name: group for name, group in groups.items() if name not in inherited}
    return document


def entries(node: yaml.Node, what: str) -> dict[str, yaml.Node]:
    """Return the entries of a mapping in order; {} for null.

    Raises:
        ParserError: it is not a mapping of names, or has a name twice.
    """
    if isinstance(node, yaml.ScalarNode) and plain(node) is None:
        return {}
    if not isinstance(node, yaml.MappingNode):
        fail(node, f"{what} must be a mapping, not {plain(node)!r}")
    _flatten(node)
    found: dict[str, yaml.Node] = {}
    for key, value in node.value:
        name = plain(key)
        if not isinstance(name, str):
            fail(key, f"{name!r} is not a name")
        if name in found:
            fail(key, f"{name!r} is given twice in {what}; the first is in line {found[name].start_mark.line + 1}")
        # Errors in a call are reported at the line of its name.
        value.start_mark = key.start_mark if isinstance(value, yaml.CollectionNode) else value.start_mark
        found[name] = value
    return found


def items(node: yaml.Node | None, what: str) -> list[yaml.Node]:
    """Return the elements of a list; [] for null."""
    if node is None or plain(node) is None:
        return []
    if not isinstance(node, yaml.SequenceNode):
        fail(node, f"{what} must be a list")
    return list(node.value)


def plain(node: yaml.Node) -> Any:
    """Return the Python value of a node.

    Raises:
        ParserError: it has none, as `!!int ""` and tags of other languages.
    """
    loader = NumbersLoader("")
    try:
        return loader.construct_object(node, deep=True)
    except yaml.MarkedYAMLError as error:
        fail(node, str(error.problem or error.context))
    finally:
        loader.dispose()


def hint(name: str, known: Iterable[str]) -> str:
    """Return `; did you mean ...?` with the known names nearest to a misspelled one, or ""."""
    close = near_misses(name, known)
    return f"; did you mean {' or '.join(map(repr, close))}?" if close else ""


def merged(child: dict[str, yaml.Node], parent: dict[str, yaml.Node]) -> dict[str, yaml.Node]:
    """Merge a group's entries with inherited ones: the child's win, and arguments of the same function are combined."""
    result = parent | child
    for name in child.keys() & parent.keys():
        own, inherited = child[name], parent[name]
        if isinstance(own, yaml.MappingNode) and isinstance(inherited, yaml.MappingNode):
            result[name] = _combined(own, inherited)
    return result


def _combined(child: yaml.MappingNode, parent: yaml.MappingNode) -> yaml.MappingNode:
    own = {plain(key) for key, _ in child.value}
    inherited = [(key, value) for key, value in parent.value if plain(key) not in own]
    return yaml.MappingNode(child.tag, inherited + child.value, child.start_mark, child.end_mark)


def _flatten(node: yaml.MappingNode) -> None:
    """Expand YAML's merge keys (`<<: *anchor`); the mapping's own entries win."""
    if any(key.tag == "tag:yaml.org,2002:merge" for key, _ in node.value):
        yaml.SafeLoader("").flatten_mapping(node)
        last = {plain(key): (key, value) for key, value in node.value}
        node.value = list(last.values())


def _inherited(node: yaml.Node) -> set[str]:
    """Return the names of the groups that a node or its descendants inherit from."""
    if isinstance(node, yaml.SequenceNode):
        return {name for each in node.value for name in _inherited(each)}
    if not isinstance(node, yaml.MappingNode):
        return set()
    below = {name for _, value in node.value for name in _inherited(value)}
    return below | {str(plain(value)) for key, value in node.value if key.value == INHERIT}


def _read(path: Path) -> dict[str, yaml.Node]:
    try:
        text = read_bounded(path)
    except TooLarge as error:
        raise ParserError(f"Error parsing {error}") from None
    except (OSError, UnicodeDecodeError) as error:
        raise ParserError(f"Error parsing {path}: it cannot be read: {error}") from error
    try:
        root = _root(text, str(path))
    except ReaderError as error:
        line = text.count("\n", 0, error.position) + 1
        raise ParserError(
            f"Error parsing {path}, line {line}: the character #x{error.character:04x} is not allowed"
        ) from error
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = f", line {mark.line + 1}" if mark else ""
        raise ParserError(f"Error parsing {path}{where}: {getattr(error, 'problem', error)}") from error
    return {} if root is None else entries(root, "the file")


def _root(text: str, name: str) -> yaml.Node | None:
    loader = NumbersLoader(text)
    loader.name = name
    try:
        return loader.get_single_node()
    finally:
        loader.dispose()
