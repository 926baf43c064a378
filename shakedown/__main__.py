"""``python -m shakedown``: the same as the command ``shakedown-bounds``."""

from shakedown.cli.main import main

if __name__ == "__main__":
    main()
