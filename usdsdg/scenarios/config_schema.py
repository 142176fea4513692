"""The JSON schema of configurations, with which editors complete keys and underline those that do not exist."""

from __future__ import annotations

from typing import Any

from pydantic.json_schema import models_json_schema

from usdsdg.scenarios.jobs import JOBS, KEY

DIALECT = "https://json-schema.org/draft/2020-12/schema"
_WITHOUT_KEY = "object_based"  # the job of a configuration without the key `job`


def config_schema(job: str | None = None) -> dict[str, Any]:
    """Return the JSON schema of the configurations of a job; None: of any, as their key `job` says.

    It knows keys, types and bounds. What needs the files themselves, such as a folder of meshes, only a run checks.
    """
    models = {name: each.model for name, each in JOBS.items() if job in (None, name)}
    found, shared = models_json_schema([(model, "validation") for model in models.values()])
    references = {name: found[model, "validation"]["$ref"] for name, model in models.items()}
    definitions = shared["$defs"]
    for name, reference in references.items():
        if name != _WITHOUT_KEY:
            definitions[reference.rpartition("/")[2]]["properties"][KEY] = {"const": name}
    schema = {"$schema": DIALECT, "title": f"usdsdg: {job or 'all jobs'}", "$defs": definitions}
    if job is not None:
        return schema | {"$ref": references[job]}
    others = [name for name in references if name != _WITHOUT_KEY]
    return schema | {
        "type": "object",
        "properties": {KEY: {"enum": others, "description": "the job; without it, the object-based scenario"}},
        "allOf": [
            {"if": _is_of(name), "then": {"$ref": references[name]}} for name in others
        ] + [{"if": {"not": {"required": [KEY]}}, "then": {"$ref": references[_WITHOUT_KEY]}}],
    }  # fmt: skip


def _is_of(job: str) -> dict[str, Any]:
    return {"required": [KEY], "properties": {KEY: {"const": job}}}
