"""What a stream runs: a configuration or a script, in a session of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from usdsdg import replicator_yaml
from usdsdg.cli.options.command_context import seed_everything
from usdsdg.cli.options.file_kinds import FileKind, kind_of
from usdsdg.cli.script.execution import ScriptEnded, execute
from usdsdg.cli.script.interpreter import interpreter_restored
from usdsdg.errors import ConfigError, GraphError, warn_once
from usdsdg.scenarios import jobs
from usdsdg.session import session

CONFIGURATIONS = (".yaml", ".yml", ".json")


@dataclass(frozen=True)
class Source:
    """A configuration of `usdsdg generate` with overrides, or a script of `usdsdg run` with arguments.

    Attributes:
        path: the configuration, Python script or Replicator YAML file.
        arguments: "key=value" overrides of a configuration, or the arguments of a script.
        seed: of the whole run; None: the configuration's, 0 for a script.
    """

    path: Path
    arguments: Sequence[str] = ()
    seed: int | None = None

    def check(self) -> None:
        """Read the file as far as is possible without running it.

        Raises:
            ConfigError: there is no such file, it is of another kind, or the configuration is wrong.
        """
        kind = self._kind()
        if kind is FileKind.CONFIGURATION:
            jobs.load_job(self.path, self._overrides)
        elif kind is FileKind.REPLICATOR_YAML and self.arguments:
            raise ConfigError(f"{self.path} is a YAML file, which takes no arguments: {' '.join(self.arguments)}")

    def run(self) -> None:
        """Run it to its end.

        Raises:
            GraphError: a script ended with an error, which has been printed; the message has its last line.
            UsdsdgError: as the job raises.
        """
        kind = self._kind()
        if kind is FileKind.CONFIGURATION:
            job, options = jobs.load_job(self.path, self._overrides)
            seed_everything(options.seed)
            job.run(options)
            return
        seed_everything(self.seed or 0)
        if kind is FileKind.REPLICATOR_YAML:
            replicator_yaml.run_file(self.path)
            return
        with interpreter_restored():
            _execute(self.path, self.arguments)

    @property
    def is_configuration(self) -> bool:
        """Whether it is a configuration, whose episodes have seeds of their own that follow from the run's."""
        return self._kind() is FileKind.CONFIGURATION

    @property
    def seed_of_run(self) -> int:
        """The seed with which it runs.

        Raises:
            ConfigError: as `check`.
        """
        if self.seed is not None:
            return self.seed
        return jobs.load_job(self.path, self._overrides)[1].seed if self.is_configuration else 0

    def tell_of_own_seed(self) -> None:
        """Warn once, while it runs, of a script that has set another global seed than was asked for."""
        own = session.current().global_seed.value
        if self.seed is not None and own != self.seed:
            warn_once(
                f"stream: {self.path} sets the global seed {own} itself, so that the seed {self.seed}, which was asked "
                "for, does not change its draws, nor does an epoch's. Leave out its set_global_seed, or let it take "
                "the seed from its arguments.",
                key=f"stream: own seed of {self.path}",
            )

    def tell_of_no_frame(self) -> None:
        """Warn, after its run, of a script that has captured nothing, so that its stream is empty."""
        run = session.current()
        if not run.orchestrator.captures:
            why = "nothing in it started a run. rep.orchestrator.run(num_frames=...) or step() does"
        elif not run.render_products:
            why = "there is no render product. rep.create.render_product makes one"
        else:
            return  # another part has its frames
        warn_once(f"stream: {self.path} ended, and has shown no frame: {why}.")

    def _kind(self) -> FileKind:
        if not self.path.is_file():
            raise ConfigError(f"there is no job {self.path}: give a configuration (.yaml, .json) or a script (.py)")
        kind = kind_of(self.path)
        if kind is None and self.path.suffix.lower() in CONFIGURATIONS:
            return FileKind.CONFIGURATION  # whose reader says what is wrong
        if kind is None or kind is FileKind.STAGE:
            raise ConfigError(f"{self.path} is no job: give a configuration (.yaml, .json) or a script (.py)")
        return kind

    @property
    def _overrides(self) -> list[str]:
        return [*self.arguments, *([f"seed={self.seed}"] if self.seed is not None else [])]


def _execute(script: Path, arguments: Sequence[str]) -> None:
    try:
        execute(script, list(arguments))
    except ScriptEnded as ended:  # whose traceback is on stderr, which a trainer may not show
        why = f": {ended.why}" if ended.why else ""
        raise GraphError(f"{script} ended with exit code {ended.exit_code}{why}") from None
