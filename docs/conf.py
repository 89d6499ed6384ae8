"""Sphinx's settings of the documentation: `python3 dev.py docs` builds it into out/site.

Nothing is fetched, neither when it is built nor when it is read: it works from a folder, offline.
"""

import re
import sys
from importlib import metadata
from pathlib import Path

from numpydoc.xref import DEFAULT_LINKS
from pygments.lexers.special import TextLexer
from sphinx.application import Sphinx

import skinfield

DOCS = Path(__file__).parent
sys.path.insert(0, str(DOCS / "_ext"))
sys.modules["skinfield.layouts"] = skinfield.layouts  # so that it is called as users call it

project = "skinfield"
release = metadata.version("skinfield")
copyright = "the authors of skinfield"
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
    "cli_reference",
    "mathml",
]
templates_path = ["_templates"]
exclude_patterns = ["figures", "_ext", "press", "**/GALLERY_HEADER.rst"]
exclude_patterns += ["api/generated/skinfield.simulate.Press.rst"]  # its name of old

# pages
myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 4

# the interface, from docstrings, which state types, shapes and units
autosummary_generate = True
autosummary_filename_map = {  # beside `press`, where a file system does not tell case
    "skinfield.simulate.Press": "skinfield.simulate.Press-class",
}
autodoc_typehints = "none"
autodoc_preserve_defaults = True
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
numpydoc_xref_param_type = True  # types that skinfield offers are links
numpydoc_xref_aliases = {word: word for word in DEFAULT_LINKS}  # which lead elsewhere: plain text
numpydoc_xref_aliases |= {name: f"skinfield.{name}" for name in dir(skinfield) if name[0].isupper()}
numpydoc_xref_ignore = "all"
default_role = "py:obj"
smartquotes_action = "qe"
maximum_signature_line_length = 80
add_module_names = False
toc_object_entries = False

# examples, run when the site is built
sphinx_gallery_conf = {
    "examples_dirs": ["../examples/gallery"],
    "gallery_dirs": ["gallery"],
    "filename_pattern": r"/",
    "within_subsection_order": "FileNameSortKey",
    "ignore_pattern": r"__init__",
    "abort_on_example_error": True,
    "show_memory": False,
    "download_all_examples": False,
    "write_computation_times": False,
    "show_signature": False,
    "thumbnail_size": (480, 320),
    "remove_config_comments": True,
    "reset_modules": (),
}

# looks
html_theme = "pydata_sphinx_theme"
html_title = "skinfield"
html_static_path = ["_static", "press"]
html_css_files = ["skinfield.css", "press.css"]
html_show_sourcelink = False
html_copy_source = False
html_logo = html_favicon = "_static/logo.svg"
html_show_sphinx = False
html_context = {"default_mode": "auto"}
html_theme_options = {
    "logo": {
        "text": "skinfield",
        "image_light": "_static/logo.svg",
        "image_dark": "_static/logo.svg",
    },
    "header_links_before_dropdown": 6,
    "navigation_with_keys": False,
    "show_nav_level": 1,
    "show_prev_next": False,
    "footer_start": ["copyright"],
    "footer_end": [],
}
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True


EXAMPLE = re.compile(r"\((?:\.\./)+examples/gallery(/[\w/]+)?(?:\.py)?\)")


def link_to_gallery(app: Sphinx, page: str, source: list[str]) -> None:
    """Lead links to an example's file, which work in the repository, to its page."""
    source[0] = EXAMPLE.sub(lambda found: f"(/gallery{found[1] or '/index'}.rst)", source[0])


def setup(app: Sphinx) -> None:
    """Show files without a lexer as text, and examples as their pages."""
    app.add_lexer("stl", TextLexer)
    app.connect("source-read", link_to_gallery)
