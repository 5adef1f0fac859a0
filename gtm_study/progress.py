"""Progress bars on standard error, one a stage, with the time that is left."""

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Protocol

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from gtm_fmu.progress import Advance


class Stages(Protocol):
    """A maker of stages: ``with stage("name") as advance`` shows a bar that ``advance(done, total)`` moves."""

    def __call__(self, name: str, share: float = 0.0) -> AbstractContextManager[Advance]:
        """A stage, and its share of the whole."""


@contextmanager
def stages(console: Console, whole: float = 0.0) -> Iterator[Stages]:
    """Stages, each with a bar; above them one of the ``whole``, of which every stage has a share, if it is not 0.

    Without a terminal a line is printed for each finished stage.
    """
    columns = TextColumn("{task.description:<36}"), BarColumn(), TimeElapsedColumn(), TimeRemainingColumn()
    with Progress(*columns, console=console, disable=not console.is_terminal) as progress:
        everything = progress.add_task("All of it", total=whole, visible=whole > 0.0)
        finished = 0.0

        @contextmanager
        def stage(name: str, share: float = 0.0) -> Iterator[Advance]:
            nonlocal finished
            task = progress.add_task(name, total=None)

            def advance(done: int, total: int) -> None:
                progress.update(task, completed=done, total=total)
                progress.update(everything, completed=finished + share * done / max(total, 1))

            yield advance
            finished += share
            progress.update(task, completed=1, total=1)
            progress.update(everything, completed=finished)
            if not console.is_terminal:
                console.print(f"{name}: done" + (f" ({finished / whole:.0%} of all)" if whole else ""))

        yield stage
