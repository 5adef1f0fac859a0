"""How a command of `gtm-fmu` reads its words: a mistake is told with the command, and with what the option wants.

The list of commands knows where each is, so that one command does not wait for the modules of the others.
"""

from collections.abc import Iterator, Mapping
from importlib import import_module
from typing import Any, NamedTuple

import typer
from typer.core import TyperCommand, TyperGroup, TyperOption
from typer.exceptions import TyperException

from gtm_fmu.errors import InputError
from gtm_study.commands.machine import check_limits

NO_SOLUTION = 3
"""Exit code where the limits leave nothing."""


class _Command(TyperCommand):
    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        for option in self.get_params(ctx):
            if isinstance(option, TyperOption) and option.nargs > 1:
                _check_values(ctx.command_path, option, args)
        try:
            return super().parse_args(ctx, args)
        except TyperException as error:
            if getattr(error, "ctx", None) is None:
                error.ctx = ctx  # type: ignore[attr-defined]
            raise

    def invoke(self, ctx: Any) -> Any:
        check_limits(str(ctx.info_name))
        return super().invoke(ctx)


def _check_values(command: str, option: TyperOption, words: list[str]) -> None:
    """Refuse an option of several values after which the next option, or the end, comes too early."""
    for place, word in enumerate(words):
        if word in option.opts:
            values = words[place + 1 : place + 1 + option.nargs]
            given = next((k for k, value in enumerate(values) if value.startswith("--")), len(values))
            if given < option.nargs:
                held = " ".join(values[:given]) or "nothing"
                wanted = f"{option.nargs} values ({option.metavar})"
                raise InputError(f"'{word}' takes {wanted}, but {held} was given; see `{command} --help`.")


class Commands(typer.Typer):
    """A group of commands; ``-h`` helps as ``--help`` does."""

    def __init__(self, add_completion: bool = False, **settings: Any) -> None:
        names = {"help_option_names": ["-h", "--help"]}
        super().__init__(context_settings=names, rich_markup_mode=None, add_completion=add_completion, **settings)

    def command(self, name: str | None = None, **settings: Any) -> Any:
        """Add a function as a command."""
        return super().command(name, cls=_Command, **settings)


class Listed(NamedTuple):
    """A command in a list: where it is in this package (``module.name``), a line about it, and examples of it."""

    place: str
    summary: str
    examples: tuple[str, ...] = ()


class _Imported(Mapping[str, Any]):
    """Commands by name; the module of one is imported when it is asked for."""

    def __init__(self, listed: Mapping[str, Listed]) -> None:
        self.listed = listed

    def __getitem__(self, name: str) -> Any:
        module, attribute = self.listed[name].place.rsplit(".", 1)
        found = getattr(import_module(f"gtm_study.commands.{module}"), attribute)
        if not isinstance(found, typer.Typer):
            alone = Commands()
            alone.command(name, epilog=_epilog(self.listed[name].examples))(found)
            found = alone
        command = typer.main.get_command(found)
        command.name = name
        return command

    def __iter__(self) -> Iterator[str]:
        return iter(self.listed)

    def __len__(self) -> int:
        return len(self.listed)


def _epilog(examples: tuple[str, ...]) -> str:
    """Closing lines of a help text, never wrapped so that they can be copied."""
    return "\n".join(("\b\nExample:", *(f"  gtm-fmu {each}" for each in examples)))


def listing(listed: Mapping[str, Listed]) -> type[TyperGroup]:
    """The class of a group that has these commands."""

    class Group(TyperGroup):
        def __init__(self, **settings: Any) -> None:
            super().__init__(**settings)
            self.commands = _Imported(listed)  # type: ignore[assignment]

        def format_commands(self, ctx: Any, formatter: Any) -> None:
            with formatter.section("Commands"):
                formatter.write_dl([(name, each.summary) for name, each in listed.items()])

    return Group
