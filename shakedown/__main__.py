"""``python -m shakedown``: the same as the command ``shakedown-bounds``."""

from shakedown.cli.main import main  # type: ignore[import-not-found]  # mypy knows it as cli.main

if __name__ == "__main__":
    main()
