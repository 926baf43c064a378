"""Pictures that a command writes."""

from pathlib import Path
from typing import Any

import click

import shakedown

ENDINGS = (".png", ".svg", ".pdf")


class PictureFile(click.Path):
    """A picture to write, or a film, found to be writable before the work starts."""

    def __init__(self, endings: tuple[str, ...] = ENDINGS) -> None:
        super().__init__(path_type=Path)
        self.endings = endings

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not str(value).lower().endswith(self.endings):
            known = " or ".join(filter(None, [", ".join(self.endings[:-1]), self.endings[-1]]))
            raise shakedown.UsageError(f"{value}: expected a name that ends in {known}")
        shakedown.check_target(value)
        return super().convert(value, param, ctx)
