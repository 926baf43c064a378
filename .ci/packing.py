"""The build backend: setuptools, with its list of what else a source distribution holds in this folder."""

from setuptools import build_meta
from setuptools.build_meta import *  # noqa: F403 - the hooks of a build backend
from setuptools.command.egg_info import manifest_maker


def build_sdist(sdist_directory: str, config_settings: dict[str, str] | None = None) -> str:
    """As setuptools does, by ``.ci/sdist.in`` instead of a MANIFEST.in at the top."""
    manifest_maker.template = ".ci/sdist.in"
    return build_meta.build_sdist(sdist_directory, config_settings)
