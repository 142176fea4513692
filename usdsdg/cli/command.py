"""Commands and arguments as they are here: with help of arguments, examples at the end, and near misses of names."""

from __future__ import annotations

import difflib
import sys
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import click

from usdsdg.cli.interrupts import INTERRUPTED
from usdsdg.cli.out_of_reach import out_of_reach

_NO_BREAK = "\N{NON-BREAKING HYPHEN}"

Function = TypeVar("Function", bound=Callable[..., Any])


class Argument(click.Argument):
    """An argument that its command's help explains, as it does options; click has that from 8.5 on.

    default_text: what holds where it is left out.
    """

    def __init__(self, *args: Any, help: str, default_text: str = "", **attributes: Any) -> None:
        super().__init__(*args, **attributes)
        notes = f"[default: ({default_text})]" if default_text else "[required]" if self.required else ""
        self.help = f"{help}  {notes}".strip()

    @property
    def human_readable_name(self) -> str:
        return super().human_readable_name.strip("[].")  # which say that it may be left out or repeated

    def get_error_hint(self, ctx: click.Context | None) -> str:
        return repr(self.human_readable_name)


def argument(*names: str, **attributes: Any) -> Callable[[Function], Function]:
    """Decorate a command with an `Argument`."""
    return click.argument(*names, cls=Argument, **attributes)


class Formatter(click.HelpFormatter):
    """Help in which no line ends within a word such as --save-stage; click breaks lines at hyphens."""

    def write_text(self, text: str) -> None:
        super().write_text(text.replace("-", _NO_BREAK))

    def write_dl(self, rows: Sequence[tuple[str, str]], *args: Any, **options: Any) -> None:
        super().write_dl([(first, second.replace("-", _NO_BREAK)) for first, second in rows], *args, **options)

    def write(self, string: str) -> None:
        super().write(string.replace(_NO_BREAK, "-"))


class Context(click.Context):
    """The context of a command, with help of the formatter above."""

    formatter_class = Formatter


class _Guessing:
    """What says what was meant by a word that it does not have."""

    def __init__(self, *args: Any, meant: Callable[[str], str] = lambda _word: "", **attributes: Any) -> None:
        """meant: returns what was meant by an option or argument, or by the name of a command; or ""."""
        super().__init__(*args, **attributes)
        self.meant = meant


class Command(_Guessing, click.Command):
    """A command whose Ctrl-C is an exit code of its own, whose summary is never cut off, and whose epilog has lines.

    A file or folder that it cannot reach is an error of one line.
    """

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        given = list(args)
        try:
            return super().parse_args(ctx, args)
        except click.NoSuchOption as error:
            if hint := self.meant(error.option_name):
                error.message, error.possibilities = f"No such option {error.option_name!r}. {hint}", None
            raise
        except click.BadParameter:
            raise
        except click.UsageError as error:  # of arguments that are too many
            _, rest, _ = self.make_parser(ctx).parse_args(given)
            if hint := next((hint for each in rest if (hint := self.meant(each))), ""):
                error.message = f"{error.message}. {hint}"
            raise

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            raise click.exceptions.Exit(INTERRUPTED) from None
        except OSError as error:
            if (known := out_of_reach(error)) is None:
                raise
            print(f"error: {known}", file=sys.stderr)
            raise click.exceptions.Exit(1) from None

    def format_help(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        self.format_usage(ctx, formatter)
        self.format_help_text(ctx, formatter)
        if rows := [(each.human_readable_name, each.help or "") for each in self.params if isinstance(each, Argument)]:
            with formatter.section("Arguments"):
                formatter.write_dl(rows)
        self.format_options(ctx, formatter)
        self.format_epilog(ctx, formatter)

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        if self.epilog:
            formatter.write(f"\n{self.epilog}\n")  # line by line as it is, where click would wrap it as text

    def get_short_help_str(self, limit: int = 0) -> str:
        return summary(self)


class Group(_Guessing, click.Group):
    """A group of commands that shows its help where none is named, and near misses of a name that it does not have."""

    command_class, context_class = Command, Context

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        # What click itself does here, where it prints, and the exit code, depend on its version.
        if not args and not ctx.resilient_parsing:
            click.echo(ctx.get_help())
            ctx.exit(2)
        given = list(args)
        try:
            return super().parse_args(ctx, args)
        except click.NoSuchOption as error:
            if command := next((each for each in given if each in self.commands), None):
                option, error.possibilities = error.option_name, None
                error.message = (
                    f"No such option {option!r} before the command. Options of a command stand after its name: "
                    f"{ctx.info_name} {command} {option} ..."
                )
            raise

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        name = args[0]
        if self.get_command(ctx, name) is None and not name.startswith("-") and not ctx.resilient_parsing:
            options = [f"--{name}"] if name in ("help", "version") else []
            near = options or difflib.get_close_matches(name, self.list_commands(ctx))
            hint = self.meant(name) or (f"Did you mean {' or '.join(map(repr, near))}?" if near else "")
            ctx.fail(f"No such command {name!r}. {hint}".rstrip())
        return super().resolve_command(ctx, args)

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(self.commands)  # in the order in which they were added

    def get_short_help_str(self, limit: int = 0) -> str:
        return summary(self)


def summary(command: click.Command) -> str:
    """Return the first paragraph of a command's help, which click would cut off at the end of a line."""
    return " ".join((command.help or "").strip().partition("\n\n")[0].split())
