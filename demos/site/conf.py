# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sphinx's settings of the course."""

project = "Contact in FEniCSx"
author = "the authors of fenicsx_contact"
copyright = "LGPL-3.0-or-later"

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.mathjax",
]
exclude_patterns = ["lessons/take", "generated", "code"]
root_doc = "index"

html_theme = "furo"
html_title = "Contact in FEniCSx: a course"
html_static_path = ["static"]
html_css_files = ["course.css"]
html_copy_source = html_show_sourcelink = False
html_show_sphinx = False

# MathJax in one file; it must not be loaded from elsewhere
mathjax_path = "tex-svg.js"
mathjax3_config = {"svg": {"fontCache": "local"}, "options": {"enableMenu": False}}

myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence", "attrs_block", "attrs_inline"]
myst_heading_anchors = 3
nb_execution_mode = "off"  # lessons.py has run them
nb_code_prompt_show = "Show the solution"
nb_code_prompt_hide = "Hide the solution"

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autoclass_content = "class"
napoleon_use_rtype = False
python_maximum_signature_line_length = 80
pygments_style = "default"


def bars(app, what, name, obj, options, lines):
    """Bars of magnitudes in docstrings are no substitutions of reStructuredText."""
    parts = "\n".join(lines).split("``")  # those between are literal
    parts[::2] = [part.replace("|", r"\|") for part in parts[::2]]
    lines[:] = "``".join(parts).split("\n")


def setup(app):
    """Called by Sphinx."""
    app.connect("autodoc-process-docstring", bars)
