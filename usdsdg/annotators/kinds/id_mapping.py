"""The mapping of a segmentation: the ids and colors that a user gives to labels and prims."""

import json
import operator
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from usdsdg.errors import AnnotatorError, warn_once

# What has no label: these words keep their case, and are keys with and without a type.
GROUNDS = ("BACKGROUND", "UNLABELLED")
# The largest id of an image of uint32.
_LAST_ID = (1 << 32) - 1

Chosen = int | tuple[int, int, int, int]  # an id, or RGBA


def read_mapping(mapping: Any) -> Mapping[str, Chosen]:
    """Return the id or color of each key: "type:label" with the label in lower case, a prim path, or a ground.

    Labels without a type have the type "class".

    mapping: a dictionary, its JSON text, or the path of a JSON file.

    Raises:
        AnnotatorError: it cannot be read, or one of its keys or values is none.
    """
    if isinstance(mapping, str):
        try:
            text = mapping if mapping.lstrip().startswith("{") else Path(mapping).read_text(encoding="utf-8")
            mapping = json.loads(text)
        except (OSError, ValueError) as error:
            raise AnnotatorError(f"mapping is {mapping!r}, which cannot be read as JSON: {error}.") from error
    if not isinstance(mapping, Mapping):
        raise AnnotatorError(
            f"mapping must be {{'type:label': RGBA or id}}, a JSON text or file of it, not {mapping!r}."
        )
    return {_key(key): _chosen(key, value) for key, value in mapping.items()}


def check_mapping(params: Mapping[str, Any]) -> None:
    """Check the "mapping" of init parameters; raises as `read_mapping`."""
    read_mapping(params["mapping"] or {})


def warn_of_shared_ids(known: Sequence[Sequence[str]], mapped: Mapping[int, int]) -> None:
    """Warn of ids that a mapping gives to something while they are those of something else.

    known: the names of each id. mapped: new ids by those before.
    """
    for old, new in mapped.items():
        if new != old and new < len(known) and new not in mapped and any(known[new]):
            warn_once(
                f"mapping gives {known[old][0]} the id {new}, which is that of {known[new][0]}, so that an image does "
                "not tell them apart. Give it an id that no other has, such as 1000, or map both."
            )


def _key(key: Any) -> str:
    """Return a key as segmentations name what they show: labels are in lower case, types and paths as they are."""
    if isinstance(key, str) and (key.startswith("/") or key in GROUNDS):
        return key
    if not isinstance(key, str):
        raise AnnotatorError(f"mapping has the key {key!r}; expected a text such as 'class:cube', or a prim path.")
    kind, label = key.split(":", 1) if ":" in key else ("class", key)
    return f"{kind}:{label if label in GROUNDS else label.lower()}"


def _chosen(key: str, value: Any) -> Chosen:
    """Return an id or a color; colors without alpha are opaque."""
    try:
        numbers = [operator.index(each) for each in _listed(value)]
    except (TypeError, ValueError):
        numbers = []
    if isinstance(value, (bool, str)):
        numbers = []
    if len(numbers) == 1 and 0 <= numbers[0] <= _LAST_ID and not isinstance(value, (list, tuple)):
        return numbers[0]
    if len(numbers) in (3, 4) and all(0 <= each <= 255 for each in numbers):
        red, green, blue, alpha = (*numbers, 255)[:4]
        return red, green, blue, alpha
    raise AnnotatorError(
        f"mapping[{key!r}] is {value!r}; expected a color (r, g, b) or (r, g, b, a) of whole numbers from 0 to 255, "
        "or an id."
    )


def _listed(value: Any) -> list[Any]:
    """Return the numbers of a color, or an id alone; floats without a fraction, as JSON may have them, are whole."""
    numbers = [value] if not hasattr(value, "__len__") else list(value)
    return [int(each) if isinstance(each, float) and each.is_integer() else each for each in numbers]
