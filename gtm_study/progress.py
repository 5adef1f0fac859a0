"""Progress bars on standard error, one a stage, with the time that is left."""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from gtm_fmu.progress import Advance


@contextmanager
def stages(console: Console) -> Iterator[Callable[[str], AbstractContextManager[Advance]]]:
    """A maker of stages: ``with stage("name") as advance`` shows a bar that ``advance(done, total)`` moves.

    Without a terminal a line is printed for each finished stage.
    """
    columns = TextColumn("{task.description:<36}"), BarColumn(), TimeElapsedColumn(), TimeRemainingColumn()
    with Progress(*columns, console=console, disable=not console.is_terminal) as progress:

        @contextmanager
        def stage(name: str) -> Iterator[Advance]:
            task = progress.add_task(name, total=None)

            def advance(done: int, total: int) -> None:
                progress.update(task, completed=done, total=total)

            yield advance
            progress.update(task, completed=1, total=1)
            if not console.is_terminal:
                console.print(f"{name}: done")

        yield stage
