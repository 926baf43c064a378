"""What the extra ``fem`` brings: scikit-fem and meshio."""

try:
    import meshio as meshio
    import skfem as skfem
except ImportError as error:
    raise ImportError(
        f"shakedown.fem needs scikit-fem and meshio ({error}): pip install 'shakedown-bounds[fem]'"
    ) from None
