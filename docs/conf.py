"""Sphinx settings of the documentation site; `make docs` builds it in out/site."""

import sys
from importlib.metadata import version as version_of
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

project = "rrrobot"
author = "The rrrobot developers"
copyright = author
release = version = version_of("rrrobot")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "run_pages",
    "mathml",
    "api_pages",
    "cli_pages",
    "cite_pages",
]
exclude_patterns = ["_ext", "_static"]
nitpicky = True
suppress_warnings = ["config.cache"]

myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
myst_links_external_new_tab = False

default_role = "code"
autodoc_typehints = "none"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
autodoc_default_options = {"members": True}
autoclass_content = "class"
python_display_short_literal_types = True
python_maximum_signature_line_length = 72
add_module_names = False
toc_object_entries = False

# Pages run in a few seconds; what they print and draw is kept until their code or rrrobot changes.
pages_cache = str(Path(__file__).parent.parent / "out" / "site-pages")

html_theme = "furo"
html_title = f"rrrobot {release}"
html_static_path = ["_static"]
html_css_files = ["rrrobot.css"]
html_js_files = ["films.js"]
html_math_renderer = "mathml"
html_copy_source = False
html_use_index = False
html_domain_indices = False
html_show_sphinx = False
html_show_copyright = False
# Summaries would be fetched, which a page opened from the disk may not do.
html_show_search_summary = False
html_theme_options = {
    "top_of_page_buttons": [],
    "light_css_variables": {
        "color-brand-primary": "#004488",
        "color-brand-content": "#004488",
        "font-stack": "system-ui, -apple-system, 'Segoe UI', 'Noto Sans', Roboto, sans-serif",
        "font-stack--monospace": "ui-monospace, 'SFMono-Regular', Menlo, Consolas, "
        "'DejaVu Sans Mono', monospace",
    },
    "dark_css_variables": {
        "color-brand-primary": "#8bb8e8",
        "color-brand-content": "#8bb8e8",
    },
}
