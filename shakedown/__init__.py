"""Shakedown analysis of elastic contacts with Coulomb friction.

Every public name, listed in ``__init__.pyi``, is loaded when it is first used, so that a command
pays only for what it needs.
"""

import lazy_loader

__version__ = "0.3.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
