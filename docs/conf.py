"""The site: ``bash .ci/site`` builds and checks it."""

import logging
import sys
from pathlib import Path

DOCS = Path(__file__).parent
sys.path.insert(0, str(DOCS / "_extensions"))

import shakedown  # noqa: E402 - after the path of the extensions

project = "shakedown"
author = "The shakedown developers"
copyright = author
version = release = shakedown.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_click",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
    "api_pages",
    "downloads",
    "mathml",
    "plain_docstrings",
]
exclude_patterns = ["_build", "_extensions", "_scripts", "gallery", "paper"]
suppress_warnings = [
    "config.cache",  # the functions of the gallery cannot be pickled
    "ref.python",  # one attribute name of several results, in prose
]

# Pages are MyST; what is indented by four is a formula in plain text.
myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 4
logging.getLogger("skfem").setLevel(logging.WARNING)  # what is assembled is no news
highlight_language = "none"
html_math_renderer = "mathml"
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True

# Docstrings give shapes and units; annotations add the types, and what comes back.
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented_params"
autodoc_typehints_format = "short"
autodoc_class_signature = "separated"
autodoc_preserve_defaults = True
napoleon_use_ivar = True
napoleon_use_rtype = False
# Looked up are the names at the top; not those of other packages (there is no network), nor of modules.
nitpick_ignore_regex = [("py:.*", r"(?!shakedown\.[A-Za-z_]+$).*")]

html_theme = "furo"
html_title = f"shakedown {release}"
html_copy_source = False
html_static_path = ["_static"]
html_css_files = ["site.css"]

sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "_gallery",
    "within_subsection_order": "FileNameSortKey",
    "abort_on_example_error": False,
    "show_memory": False,
    "min_reported_time": 60,
    "remove_config_comments": True,
    "download_all_examples": False,
    "show_signature": False,
    "capture_repr": (),
}

linkcheck_ignore = [r"http://127\.0\.0\.1.*", r"tcp://.*"]
linkcheck_anchors = False
linkcheck_timeout = 20
