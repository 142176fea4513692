"""The conditions under which a script runs: what its author had open, where its assets are, what is let pass."""

from __future__ import annotations

import enum
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from usdsdg.cli.options.map_option import use_maps


class NewStageOption(enum.StrEnum):
    """Values of --new-stage."""

    KIT = "kit"
    ISAAC = "isaac"


class MissingOption(enum.StrEnum):
    """Values of --missing-assets."""

    ERROR = "error"
    STAND_IN = "stand-in"
    SKIP = "skip"


class ReplicatorOption(enum.StrEnum):
    """Values of --replicator: the generation of Replicator whose payloads a script gets."""

    FOUR = "4"
    SIX = "6"


@dataclass(frozen=True)
class Conditions:
    """What the options before a script say."""

    stage: Path | None = None
    new_stage: NewStageOption | None = None
    frames: int | None = None
    replicator: ReplicatorOption | None = None
    maps: Sequence[str] = ()
    missing_assets: MissingOption = MissingOption.ERROR
    lenient: bool = False
    is_recorded: bool = False  # a recipe tells them, so that only the places of assets can be chosen

    def facts(self) -> dict[str, Any]:
        """Return what a recipe has of them: all but the places of assets, which differ from machine to machine."""
        return {
            "stage": self.stage.name if self.stage is not None else None,
            "new_stage": self.new_stage and self.new_stage.value,
            "frames": self.frames,
            "replicator": self.replicator and self.replicator.value,
            "missing_assets": self.missing_assets.value if self.missing_assets is not MissingOption.ERROR else None,
            "lenient": self.lenient,
        }

    @classmethod
    def of_facts(cls, facts: Mapping[str, Any], stage: Path | None, maps: Sequence[str] = ()) -> Conditions:
        """Return the conditions that a recipe tells; stage: where the stage is, if there was one."""
        return cls(
            stage,
            NewStageOption(facts["new_stage"]) if facts.get("new_stage") else None,
            facts.get("frames"),
            ReplicatorOption(facts["replicator"]) if facts.get("replicator") else None,
            maps,
            missing_assets=MissingOption(facts.get("missing_assets") or MissingOption.ERROR),
            lenient=bool(facts.get("lenient")),
            is_recorded=True,
        )

    def apply(self, script: Path) -> None:
        """Set up the session; the stage is opened last, since it may need the maps.

        Raises:
            ConfigError: a map, or a file of maps, is wrong.
            AssetError: the stage is missing or unreadable.
        """
        from usdsdg import errors
        from usdsdg.session import stage_context
        from usdsdg.session.new_stages import NewStage
        from usdsdg.session.settings.store import get_settings
        from usdsdg.stage import assets
        from usdsdg.stage.poses.transforms import meters_per_unit

        use_maps(self.maps, script)
        assets.set_units(lambda: meters_per_unit(stage_context.current_stage()))
        errors.set_lenient(self.lenient)
        if self.replicator is not None:
            get_settings().set("/usdsdg/replicator/version", int(self.replicator))
        if self.new_stage is not None:
            stage_context.use_new_stages(NewStage(self.new_stage.value))
        if self.stage is not None:
            # As it would be from any working folder: how it is typed says nothing of the run.
            there = Path(os.path.expanduser(self.stage)).absolute()
            stage_context.open_at_start(there if there.exists() else self.stage)
        # After the stage, which must be there in any case.
        assets.set_on_missing(assets.OnMissing(self.missing_assets.value), is_chosen=not self.is_recorded)
        if not self.lenient:
            errors.watch_swallowed()
