"""The site of these documents: ``make docs`` (tools/site.py puts README, CONTRIBUTING and CHANGELOG beside them)."""

project = "sstl"
author = "The sstl-cli maintainers"
project_copyright = author
extensions = ["myst_parser"]
source_suffix = {".md": "markdown"}
myst_heading_anchors = 3
html_theme = "alabaster"
html_theme_options = {
    "description": "Tendon-sheath hysteresis: identify, compensate, diagnose",
    "page_width": "72rem",
    "sidebar_collapse": True,
}
html_title = "sstl"
html_copy_source = False
html_show_sourcelink = False
html_sidebars = {"**": ["about.html", "searchfield.html", "navigation.html"]}
# the same sources give the same pages
html_last_updated_fmt = None
nitpicky = True
