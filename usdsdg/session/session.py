"""The session: one object that holds all state of the process, such as the current stage, settings and engines."""

from __future__ import annotations

import atexit
import contextlib
import importlib
import logging
import os
import sys
import threading
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any
from weakref import ReferenceType, WeakValueDictionary

from pxr import Usd, UsdUtils

from usdsdg import errors
from usdsdg.listeners import Listeners
from usdsdg.operating_system import hold_standard_descriptors
from usdsdg.session.new_stages import NewStage
from usdsdg.stage import assets, usd_threads
from usdsdg.stage.assets import anchors, objects, opened

if TYPE_CHECKING:
    from usdsdg.parallel import Later
    from usdsdg.readback import Arrival
    from usdsdg.session.settings.store import Settings
    from usdsdg.session.timeline import Timeline


def _imported(name: str) -> Any:
    module, _, attribute = name.partition(":")
    return getattr(importlib.import_module(module), attribute)


def _tell_of_demo_assets() -> None:
    _imported("usdsdg.session.progress:say_once")(
        "demo assets, simple shapes and skies made by code, stand in for Isaac Sim's, not for files of yours: no "
        "assets root is set "
        f"(--assets-root, {assets.ROOT_VARIABLE}, or usdsdg.stage.assets.set_assets_root)"
    )


def _part(factory: str) -> Any:
    """Return a lazy member: its first use imports and calls `factory`, given as "module:name"."""
    return cached_property(lambda _session: _imported(factory)())


class _OpenBlocks(threading.local):
    """What `with` blocks of a thread are open: see `usdsdg.graph.node`. Another thread is in none of them."""

    def __init__(self) -> None:
        self.triggers: list[Any] = []
        self.groups: list[tuple[str, ...]] = []
        self.lines: list[str] = []


class Session:
    """All state of the process; functions such as `get_timeline()` return its members.

    Members of higher packages are named, not imported, so that every package above `usdsdg.stage` can import this
    module.
    """

    engines = _part("usdsdg.session.engines:Engines")
    reporter = _part("usdsdg.session.progress:reporter_of_library")
    global_seed = _part("usdsdg.graph.sampling:GlobalSeed")
    graph = _part("usdsdg.graph.evaluate:Graph")
    random_generators = _part("weakref:WeakSet")  # every live ReplicatorRNG
    nodes = _part("weakref:WeakSet")  # every live node of the current stage, those that items of scripts hold included
    default_generator = _part("usdsdg.rng:ReplicatorRNG")
    io_queue = _part("usdsdg.writers.backends.io_queue:IoQueue")
    run = _part("usdsdg.writers.journal.run:Run")
    class_tables = _part("usdsdg.annotators.class_table:ClassTables")
    app = _part("usdsdg.app.app:App")
    orchestrator = _part("usdsdg.app.frame_loop:Orchestrator")
    observations = _part("usdsdg.session.observations:Observations")
    live = _part("usdsdg.capture.live:LiveView")
    articulations = _part("usdsdg.articulations.articulations:Articulations")
    runtime_values = _part("usdsdg.compat.wrappers.runtime_values:RuntimeValues")
    viewport = _part("usdsdg.compat.omni.kit.viewport.utility:Viewport")
    omnigraph = _part("usdsdg.compat.omni.graph.graphs:Graphs")
    synthetic_data = _part("usdsdg.compat.omni.syntheticdata.synthetic_data:SyntheticData")
    simulation = _part("usdsdg.compat.isaacsim.core.simulation_manager.simulation:Simulation")
    event_dispatcher = _part("usdsdg.compat.carb.eventdispatcher:EventDispatcher")
    domain_randomization = _part("usdsdg.compat.isaacsim.replicator.randomization.registry:Registry")
    script_manager = _part("usdsdg.compat.omni.behavior.scripting.script_manager:ScriptManager")
    stage_events = _part("usdsdg.compat.stage_events:StageEvents")
    event_streams = _part("usdsdg.compat.carb.events:EventStreams")
    extension_manager = _part("usdsdg.compat.omni.ext:ExtensionManager")
    selection = _part("usdsdg.compat.omni.usd:Selection")
    physics_sensors = _part("usdsdg.compat.isaacsim.sensors.physics.known_sensors:KnownSensors")
    path_ids = _part("usdsdg.compat.physics_schema_tools:PathIds")

    def __init__(self) -> None:
        self.note_before = opened.last_note()  # of the files that were read before this was made
        self.stage: Usd.Stage | None = None
        self.opened_stage: Usd.Stage | None = None  # the one that is open when a script starts
        self.saved_as: str | None = None  # the file that a script has saved the current stage as
        self.new_stage_kind = NewStage.EMPTY
        self.has_viewport = False  # every stage gets the cameras of the application's viewport
        self.stage_listeners: Listeners[[Usd.Stage]] = Listeners()  # of a stage that has become the current one
        self.closing_listeners: Listeners[[Usd.Stage]] = Listeners()  # of one that is about to be replaced
        self._blocks = _OpenBlocks()
        self.render_products: dict[str, Any] = {}  # HydraTexture by prim path, oldest first
        self.annotators: list[Any] = []  # attached by users, in the order of attaching
        self.writers: list[Any] = []  # attached, in the order of attaching
        # By output folder, the first live backend that wrote into it.
        self.backends: WeakValueDictionary[str, Any] = WeakValueDictionary()
        # By output folder or URL, what stands for the first writer that was due there, and that writer.
        self.writers_turns: dict[str, tuple[object, ReferenceType[Any]]] = {}
        self.companion: Any = None  # a `JobRecording`, which records what writers are attached to
        self.tap: Any = None  # a `usdsdg.capture.tap.Tap`, which gets the frames in place of the writers
        self.worlds: Any = None  # a `usdsdg.capture.worlds.WorldTap`, which gets many worlds at each step
        self.frames_together = (
            1  # frames that are drawn and path-traced together, where the graph alone decides on them
        )
        self.simulation_context: Any = None  # a `SimulationContext` or `World`, of which there is one
        self.label_filter: str | None = None  # of annotators without one of their own; None: all labels
        self.label_filter_sets = 0  # how often a script set it
        self.metadata_seed: int | None = None  # the global seed of the latest captured frame
        # Where output may go while a file that is no program says where, such as a YAML graph; None: anywhere.
        self.confined_to: Path | None = None
        self.disk_root: Path | None = None  # parent of relative output folders; None: the default
        self.tracing: Later | Arrival | None = None  # of the latest frame's color images, where its files wait for them
        # By output folder or URL, the classes of the writers that were due there.
        self.writers_kinds: dict[str, set[type]] = {}
        self.written_folders: dict[str, None] = {}  # on disk, in the order of their first file
        self.imported_version = 0  # of Replicator, as the script's imports tell; 0: they do not
        self.failed_at_exit = False  # a file could not be written and no call has raised it
        self.said: set[str] = set()  # lines of `progress.say_once`
        self.told_causes: set[str] = set()  # of errors that were printed
        anchors.forget_named()
        assets.set_fallback_root(lambda: _imported("usdsdg.demo:root")(), _tell_of_demo_assets)
        assets.set_mesh_converter(
            lambda file, label: _imported("usdsdg.meshes.for_stage:converted_for_stage")(file, label)
        )
        assets.set_mirror_factory(lambda url: _imported("usdsdg.mirror.root_mirror:RootMirror")(url))

    @property
    def open_triggers(self) -> list[Any]:
        """The triggers whose `with` blocks are open on this thread, innermost last."""
        return self._blocks.triggers

    @property
    def open_groups(self) -> list[tuple[str, ...]]:
        """The prims whose `with` blocks are open on this thread, innermost last."""
        return self._blocks.groups

    @property
    def source_lines(self) -> list[str]:
        """The lines of `graph.node.made_at` on this thread, innermost last."""
        return self._blocks.lines

    @cached_property
    def timeline(self) -> Timeline:
        timeline = _imported("usdsdg.session.timeline:Timeline")()
        timeline.subscribe(self._on_timeline)
        return timeline

    @cached_property
    def settings(self) -> Settings:
        settings = _imported("usdsdg.session.settings.store:Settings")()
        settings.on_change("/omni/replicator/globalSeed", self._on_global_seed)
        settings.on_change("/omni/replicator/backends/disk/root_dir", self._on_disk_root)
        settings.on_change("/usdsdg/progress", _imported("usdsdg.session.progress:use_of_library"))
        backend = "/omni/replicator/backend"
        settings.on_change(f"{backend}/queueSize", lambda jobs: self.io_queue.set_max_queue_size(jobs))
        settings.on_change(f"{backend}/writeThreads", lambda count: self.io_queue.set_threads(count))
        settings.on_change("/usdsdg/writers/queueBytes", lambda count: self.io_queue.set_max_bytes(count))
        return settings

    def wait_for_pictures(self) -> None:
        """Wait until the latest frame's color images have their pixels; raises what went wrong."""
        if self.tracing is not None:
            self.tracing.wait()

    def close_run(self) -> None:
        """Close the journals of the run at the end of a program that has no command to do so."""
        for run in self._made("run"):
            if run.is_copy:
                return
            run.follow_moved()
            try:
                # Python keeps the error that ends a program there.
                run.close(complete=getattr(sys, "last_value", None) is None and not self.failed_at_exit)
            except errors.UsdsdgError as error:
                _imported("usdsdg.session.endings.failures:tell")(error)
                self.failed_at_exit = True
        if self.written_folders and not self.failed_at_exit:
            self._name_next_commands()

    def end_run(self) -> None:
        """Write what waits, and close the journals of a run that others follow in this process.

        Raises:
            UsdsdgError: a file cannot be written.
        """
        for run in self._made("run"):
            if run.folders and not run.is_closed and not run.is_copy:
                run.follow_moved()
                self.io_queue.finish_early()
                run.close(complete=True)
                run.release()

    def _name_next_commands(self) -> None:
        folders = _imported("usdsdg.session.next_commands:written_datasets")()
        for line in _imported("usdsdg.session.next_commands:next_commands")(folders):
            self.reporter.say(line)

    def say_remarks(self) -> None:
        """Say at the end of a program that has no command to do so what its author will not have wanted.

        Nothing is said of one that an error has ended, of one that a person types line by line, and of the processes
        that `multiprocessing` starts, which import the program again.
        """
        from multiprocessing import parent_process

        is_whole = getattr(sys, "last_value", None) is None and not hasattr(sys, "ps1") and parent_process() is None
        if is_whole and self._made("observations"):
            for remark in _imported("usdsdg.session.remarks:remarks_of_program")():
                self.reporter.say(f"remark: {remark}")

    def _made(self, *names: str) -> list[Any]:
        """Return the named members that have been used; the others have no state yet."""
        return [vars(self)[name] for name in names if name in vars(self)]

    # --- reactions to a new stage, the timeline and settings ---
    def begin_stage(self, stage: Usd.Stage) -> None:
        """Reset all state that belongs to a stage, in this order, then call the listeners of new stages."""
        errors.forget_warnings()
        self.saved_as = None
        objects.forget_latest()
        anchors.forget_left_folders()
        self.timeline.reset()
        if self.has_viewport:
            _imported("usdsdg.stage.cameras.viewport_cameras:author")(stage)
        self.timeline.begin_stage(stage)
        for part in self._made("engines", "graph", "live", "omnigraph", "class_tables"):
            part.reset()
        self.nodes.clear()
        self.render_products.clear()
        for part in self._made("orchestrator", "selection"):
            part.reset()
        for annotator in tuple(self.annotators):
            annotator.release()
        for writer in tuple(self.writers):
            writer.detach()
        self.stage_listeners.call(stage)

    def _on_timeline(self, event: str) -> None:
        if event == "play":
            # What physics finds when it begins to play is what it restores at a stop.
            for part in self._made("graph"):
                part.run_impulses()
        self.engines.follow_timeline(event)
        for part in self._made("orchestrator"):
            part.follow_timeline(event)

    def _on_global_seed(self, seed: Any) -> None:
        self.global_seed.follow_setting(seed)
        for generator in list(self.random_generators):
            generator.reset()
        for part in self._made("graph"):
            part.restart_draws()

    def _on_disk_root(self, folder: str) -> None:
        if self.confined_to is not None:
            raise errors.OutputNotWritable(
                f"a file that is no program sets /omni/replicator/backends/disk/root_dir to {folder!r}, out of "
                f"{self.confined_to}. {errors.ALLOW_OUTSIDE}"
            )
        self.disk_root = Path(os.path.expanduser(folder)) if folder else None


_session = Session()


def current() -> Session:
    """The session of this process."""
    return _session


def restart() -> None:
    """Start a new session, as a new process would; keeps the I/O queue, the progress reporter and the devices.

    Datasets of the session before have ended then, with their journals.

    Raises:
        UsdsdgError: a file of theirs cannot be written.
    """
    global _session
    _session.end_run()
    before, _session = _session, Session()
    for engines in before._made("engines"):
        engines.reset()
        _session.engines.device, _session.engines.physics_device = engines.device, engines.physics_device
    if before.stage is not None:
        UsdUtils.StageCache.Get().Erase(before.stage)
    for name in ("io_queue", "reporter"):
        for part in before._made(name):
            setattr(_session, name, part)


def _end_program() -> None:
    """Say the last remarks; exit with code 1 if a file could not be written and no call has raised the failure.

    At exit neither an exception nor sys.exit changes the exit code any more; only `os._exit` does. Functions registered
    with atexit run last to first, so all that were registered after usdsdg was imported have run by now.
    """
    if _session.failed_at_exit:
        logging.shutdown()
        for stream in filter(None, (sys.stdout, sys.stderr)):
            with contextlib.suppress(OSError, ValueError):  # closed, or a pipe without a reader
                stream.flush()
        os._exit(1)
    _session.say_remarks()


atexit.register(_end_program)
hold_standard_descriptors()
usd_threads.prepare_forks()
