"""The site: Sphinx with MyST, warnings as errors; `make docs` builds it into docs/build."""

import sys
from importlib.metadata import metadata
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent / "extensions"), str(Path(__file__).parents[1])]

_about = metadata("longwave")

project = _about["Name"]
author = _about["Author"]
release = version = _about["Version"]

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
    "longwave_site",
]
exclude_patterns = ["build"]
myst_enable_extensions = ["deflist", "dollarmath"]
default_role = "code"
toc_object_entries = False
nitpicky = True
# Types in signatures are other libraries' as well, and nothing is fetched from them.
nitpick_ignore_regex = [("py:(class|exc)", r".*")]

autodoc_default_options = {
    "members": True,
    "member-order": "bysource",
    "no-value": True,
    "exclude-members": "set",  # which Matplotlib writes into each class of figures
}
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True

html_theme = "furo"
html_title = "longwave"
html_math_renderer = "mathml"
html_copy_source = False
html_show_copyright = False
html_static_path = ["static"]
html_css_files = ["site.css"]

# Copied is what is typed: no prompts, and no output where there are prompts.
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True
