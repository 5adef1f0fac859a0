"""How a command of `gtm-fmu` reads its words: a mistake is told with the command, and with what the option wants."""

from typing import Any

import typer
from typer.core import TyperCommand, TyperOption
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

    def __init__(self, **settings: Any) -> None:
        names = {"help_option_names": ["-h", "--help"]}
        super().__init__(context_settings=names, rich_markup_mode=None, **settings)

    def command(self, name: str | None = None, **settings: Any) -> Any:
        """Add a function as a command."""
        return super().command(name, cls=_Command, **settings)
