"""Progress on the terminal: a bar on stderr where a person looks on, nothing where it is a file or a pipe."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bar

from rgcore.pipeline import STAGES
from rgcore.progress import Progress, Watcher


@contextmanager
def progress_bar() -> Iterator[Watcher]:
    """A watcher that draws one bar: the stage, its share done, the time since the start."""
    console = Console(stderr=True)
    columns = TextColumn("{task.description:<10}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    with Bar(*columns, console=console, disable=not console.is_terminal, transient=True) as bar:
        task = bar.add_task("reading", total=None)

        def watch(p: Progress) -> None:
            number = f"{STAGES.index(p.stage) + 1}/{len(STAGES)} " if p.stage in STAGES else ""
            bar.update(task, description=f"{number}{p.stage}", completed=p.done, total=p.total)

        yield watch
