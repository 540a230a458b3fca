"""The documentation as a site: `make docs` builds it in build/docs/html, without a network."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import plica
from extension.cpp import XML

project = "Plica"
author = "the Plica developers"
copyright = f"2026, {author}"  # noqa: A001  what Sphinx calls it
release = version = plica.__version__

extensions = [
    "breathe",
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.viewcode",
    "sphinx_gallery.gen_gallery",
    "extension",
]
exclude_patterns = ["tutorials/README.txt", "tutorials/*.py"]
nitpicky = False

myst_enable_extensions = ["dollarmath", "amsmath"]
myst_heading_anchors = 4
html_math_renderer = "mathml"

html_theme = "pydata_sphinx_theme"
html_title = f"Plica {version}"
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {
    "navigation_with_keys": False,
    "show_nav_level": 1,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "use_edit_page_button": False,
}

breathe_projects = {"plica": str(XML)}
breathe_default_project = "plica"
breathe_show_include = False
suppress_warnings = ["duplicate_declaration.cpp"]  # each header declares the namespace anew

autodoc_typehints = "none"
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False

sphinx_gallery_conf = {
    "examples_dirs": "tutorials",
    "gallery_dirs": "gallery",
    "filename_pattern": r"/\d\d_",
    "within_subsection_order": "FileNameSortKey",
    "show_memory": False,
    "show_signature": False,
    "write_computation_times": False,
    "download_all_examples": False,
    "remove_config_comments": True,
    "min_reported_time": 0,
    "abort_on_example_error": True,
    "image_scrapers": ("matplotlib",),
    "default_thumb_file": None,
}
