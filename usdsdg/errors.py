"""Errors and warnings of usdsdg.

UsdsdgError                     base of all errors; the command line prints it without a traceback
├── StageError                  a stage or prim that cannot be used as asked (BadPrim, NotAPrim, BadValue, ...)
├── AssetError                  a file that is missing or unreadable (AssetNotFound, AssetUnreadable)
├── ConfigError                 a configuration file with wrong keys, types or values
├── GraphError                  a node, trigger, distribution or event that cannot work as written
│   ├── ArgumentError           an argument of a function that is of the wrong type, shape or value (WrongType)
│   └── UnknownInput            an input or output that a node does not have
├── PhysicsError                a body or collider that cannot be simulated
├── RenderError                 a camera or scene that cannot be rendered (OutOfDeviceMemory)
├── AnnotatorError              an annotator that cannot give its data (AnnotatorRegistryError, AugmentationError)
├── DatasetError                a folder that contains no dataset
├── WriterError                 output that cannot be written (OutputNotWritable, WriterArgumentError, ...)
├── StoreError                  a folder, bucket or server that does not answer, does not exist or denies access
└── Unsupported                 a feature of Replicator or USD that usdsdg does not support
"""

import os
import sys
import sysconfig
import threading
import warnings
import weakref
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Self

# The remedy where a file says that output goes elsewhere than such files may say.
ALLOW_OUTSIDE = "Give a relative path below it, or let the file decide with --allow-outside."


class UsdsdgError(Exception):
    """Base of all errors of usdsdg; messages name the prim or argument, the cause and the remedy."""

    cause = ""  # where other files fail by it, too, such as a full disk


class LosingError(UsdsdgError):
    """Base of errors after which a dataset lacks something; a script that catches one and goes on is pointed out."""

    _watched_by: list[str] | None

    def __new__(cls, *args: object, **kwargs: object) -> Self:
        error = super().__new__(cls, *args, **kwargs)
        error._watched_by = _swallowed
        if _swallowed is not None:
            _living.add(error)
        return error

    def __del__(self) -> None:
        if _swallowed is not None:
            _note_swallowed(self)


class ScriptStopped(BaseException):
    """Ends a script silently when the stream of its frames is closed.

    It is no Exception, so that `except Exception` in the script does not catch it.
    """


class StageError(UsdsdgError):
    """A stage or prim cannot be used as requested."""


class BadPrim(StageError, ValueError):
    """A prim path is missing, invalid or of the wrong type."""


class NotAPrim(BadPrim, TypeError):
    """A prim argument is neither a prim, nor a path, nor an item."""


class BadValue(StageError, ValueError):
    """A value has a type or size that an attribute does not take."""


class DegenerateFrame(StageError, ValueError):
    """A coordinate frame is degenerate, e.g. eye and target coincide or the view direction is parallel to up."""


class AssetError(LosingError):
    """A file that a scene needs is missing or unreadable; `looked_for` says where it was looked for."""

    looked_for: Sequence[str] = ()


class AssetNotFound(AssetError, FileNotFoundError):
    """An asset URL has no file under the assets root."""


class AssetUnreadable(AssetError, ValueError):
    """A file exists but its contents cannot be read."""


class ConfigError(UsdsdgError, ValueError):
    """A configuration has unknown keys, wrong types or impossible values."""


class GraphError(UsdsdgError, ValueError):
    """A node of the randomization graph cannot be executed as written."""


class ArgumentError(GraphError):
    """An argument has the wrong type, shape or value, or does not fit the stage; the message names the argument.

    It is a GraphError, so that scripts which catch GraphError also catch wrong arguments.
    """


class WrongType(ArgumentError, TypeError):
    """An argument is of a type for which Replicator raises TypeError, too."""


class UnknownInput(GraphError, KeyError):
    """A node has no input or output of that name; the message lists those that it has."""

    # That of KeyError puts the message in quotes.
    __str__ = Exception.__str__


class PhysicsError(LosingError):
    """A stage cannot be simulated as authored."""


class RenderError(UsdsdgError):
    """A camera, light or mesh cannot be rendered as authored."""


class OutOfDeviceMemory(RenderError):
    """What is to be rendered does not fit into the memory of the device."""


class AnnotatorError(UsdsdgError):
    """An annotator cannot give its data."""


class AnnotatorRegistryError(AnnotatorError, LookupError):
    """No annotator has that name, or the name is taken."""


class AugmentationError(AnnotatorError):
    """An augmentation failed or returned something that is not an array."""


class NoAugmentation(AugmentationError, AnnotatorRegistryError, KeyError):
    """No augmentation has that name."""

    __str__ = Exception.__str__  # that of KeyError would put the message in quotes


class DatasetError(UsdsdgError, ValueError):
    """A folder is missing, or contains no dataset of a known writer."""


class WriterError(LosingError):
    """A writer or its backend failed."""


class WriterArgumentError(WriterError, ValueError):
    """Arguments of a writer that exclude each other."""


class WriterRegistryError(WriterError, LookupError):
    """No writer or backend has that name, or the name is taken."""


class InvalidWriterError(WriterRegistryError):
    """A writer is not one, or is not attached."""


class StoreError(LosingError, OSError):
    """A folder, bucket or server of files does not answer, does not exist, or denies access."""


class OutputNotWritable(WriterError, StoreError):
    """The output folder, bucket or file cannot be written."""


class WorkerFailed(UsdsdgError):
    """A process that makes a part of a dataset has failed."""


class DatasetInTheWay(OutputNotWritable):
    """The output folder has another run, or another process writes to it."""


class Unsupported(UsdsdgError, NotImplementedError):
    """A feature of Replicator or USD that usdsdg does not support."""

    looked_for: Sequence[str] = ()  # of a URL: where a copy of it was looked for


def counted(count: int, noun: str, plural: str | None = None) -> str:
    """Return a number with its noun, for messages: "1 frame", "2 frames"; plural: where it is not the noun with an s.

    A verb after the noun belongs to both: `counted(count, "file is", "files are")`.
    """
    return f"{count} {noun if count == 1 else plural or f'{noun}s'}"


def described(error: BaseException) -> str:
    """Return the message of an error, with its notes in lines of their own."""
    return "\n".join([str(error), *(f"  {note}" for note in getattr(error, "__notes__", ()))])


class MissingName:
    """Message of the AttributeError for a missing name of a module; near names are searched when it is formatted.

    Python asks a package for names on its way to submodules, while the modules that know better are being imported.
    """

    def __init__(self, module: str, name: str, hint: Callable[[], str]) -> None:
        """hint: returns "; ..." with where the name is, or similar ones; or ""."""
        self._module, self._name, self._hint = module, name, hint

    def __str__(self) -> str:
        return f"module {self._module!r} has no attribute {self._name!r}{self._hint()}"

    __repr__ = __str__


class UsdsdgWarning(UserWarning):
    """Something was ignored, approximated or replaced; the message names the prim and the remedy."""


# Folders of the project's packages; "<string>" is the __init__ that dataclasses generate.
_ROOT = Path(__file__).resolve().parents[1]
OWN_FILES = (*(f"{_ROOT / name}{os.sep}" for name in ("usdsdg", "usdsdg_physics", "usdsdg_render")), "<string>")

_warned: set[str] = set()
_warned_lock = threading.Lock()
_remembering = False  # whether a new stage does not let messages be issued again


def warn_once(message: str, *, key: str | None = None) -> None:
    """Issue a `UsdsdgWarning` unless one with the same `key` (default: the message) was issued for this stage."""
    with _warned_lock:
        if (key or message) in _warned:
            return
        _warned.add(key or message)
    warnings.warn(message, UsdsdgWarning, stacklevel=_level_of_caller())


def _level_of_caller() -> int:
    """Return the `stacklevel`, for the calling function, of the nearest line outside the project."""
    frame, level = sys._getframe(1), 1
    while frame.f_back is not None and frame.f_code.co_filename.startswith(OWN_FILES):
        frame, level = frame.f_back, level + 1
    return level


def outside_line() -> str:
    """Return the nearest line outside the project that is being executed, as in `my_script.py:41`; "" if none is."""
    frame = sys._getframe(1)
    while frame.f_back is not None and frame.f_code.co_filename.startswith(OWN_FILES):
        frame = frame.f_back
    name = frame.f_code.co_filename
    by_command = frame.f_globals.get("__name__", "").startswith("click.")  # as for a stage that --stage opens
    return (
        "" if by_command or name.startswith((*OWN_FILES, "<frozen ")) else f"{os.path.basename(name)}:{frame.f_lineno}"
    )


def forget_warnings() -> None:
    """Allow every `warn_once` message to be issued again, as a new stage does."""
    with _warned_lock:
        if not _remembering:
            _warned.clear()


@contextmanager
def warnings_remembered() -> Iterator[None]:
    """Issue no `warn_once` message twice in the context, whatever stages are opened in it."""
    global _remembering
    before, _remembering = _remembering, True
    try:
        yield
    finally:
        _remembering = before


# --- what Replicator lets pass ---
_lenient = False


def set_lenient(lenient: bool) -> None:
    """Choose whether what Replicator lets pass is a warning or, by default, an error."""
    global _lenient
    _lenient = lenient


def is_lenient() -> bool:
    """Return whether what Replicator lets pass is a warning."""
    return _lenient


def let_pass(error: UsdsdgError) -> None:
    """Raise an error that Replicator would not, or warn once with its message if `set_lenient` says so.

    Raises:
        UsdsdgError: the error, unless errors are let pass.
    """
    if not _lenient:
        raise error
    warn_once(str(error))


# --- errors that a script catches ---
_swallowed: list[str] | None = None  # None: not watched
_living: weakref.WeakSet[LosingError] = weakref.WeakSet()
_LIBRARIES = tuple({f"{sysconfig.get_path(name)}{os.sep}" for name in ("stdlib", "purelib", "platlib")})
_foreign: list[Exception] = []  # errors of a script's own writers
_KEPT = 5  # of these, since their frames hold arrays


def watch_swallowed() -> None:
    """From now on record each `LosingError` that is raised into code outside the project and caught there."""
    global _swallowed
    _swallowed = []
    _living.clear()
    _foreign.clear()


def watch_foreign(error: Exception) -> None:
    """Treat an error of another class like a `LosingError`, as one that a script's own writer raises."""
    if _swallowed is not None and len(_foreign) < _KEPT and not isinstance(error, LosingError):
        _foreign.append(error)


def take_swallowed() -> list[str]:
    """Return one line for each error that was caught outside the project, and stop recording."""
    global _swallowed
    for error in (*_living, *_foreign):
        _note_swallowed(error)
    _foreign.clear()
    found, _swallowed = _swallowed or [], None
    return list(dict.fromkeys(found))


def _note_swallowed(error: Exception) -> None:
    if _swallowed is None or getattr(error, "_watched_by", _swallowed) is not _swallowed:
        return
    # A traceback begins at the frame in which the error was caught.
    trace = error.__traceback__
    if trace is None or not is_script(trace.tb_frame.f_code.co_filename):
        return
    while trace.tb_next is not None and is_script(trace.tb_next.tb_frame.f_code.co_filename):
        trace = trace.tb_next
    place = f"{os.path.basename(trace.tb_frame.f_code.co_filename)}:{trace.tb_lineno}"
    _swallowed.append(f"{place}: {type(error).__name__}: {error}")


# --- errors of functions that are called for a script ---
@contextmanager
def called_for_script(what: str) -> Iterator[None]:
    """Let an error that is raised in a function of the script, called in the context, say which function that is.

    what: what the function is for, such as "the trigger of BasicWriter".
    """
    try:
        yield
    except Exception as error:
        name_callback(error, what)
        raise


def name_callback(error: Exception, what: str) -> None:
    """Add a note with the name, file and line of the outermost function of a script that raised an error, if any did.

    Of several that call each other the innermost call adds the first note; one function is named once.
    """
    trace = error.__traceback__
    while trace is not None and not is_script(trace.tb_frame.f_code.co_filename):
        trace = trace.tb_next
    if trace is None:
        return
    code = trace.tb_frame.f_code
    raised = f"(raised in {code.co_qualname}, {os.path.basename(code.co_filename)}:{code.co_firstlineno}, "
    if not any(note.startswith(raised) for note in getattr(error, "__notes__", ())):
        error.add_note(f"{raised}{what})")


def note_line(failure: UsdsdgError, error: BaseException) -> None:
    """Add a note to a failure with the innermost line of a script at which its cause was raised, if any was."""
    line, trace = "", error.__traceback__
    while trace is not None:
        code = trace.tb_frame.f_code
        if is_script(code.co_filename):
            line = f"{os.path.basename(code.co_filename)}:{trace.tb_lineno}, in {code.co_qualname}"
        trace = trace.tb_next
    if line:
        failure.add_note(f"(raised at {line})")


def is_script(filename: str) -> bool:
    """Whether a file of code belongs neither to the project, nor to Python, nor to an installed package."""
    return not filename.startswith((*OWN_FILES, *_LIBRARIES, "<frozen "))
