"""The site of these documents: `make docs` builds it into target/docs."""

from docutils import nodes
from latex2mathml.converter import convert

project = "soilsig"
author = "the soilsig authors"

extensions = ["myst_nb"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
nb_execution_mode = "off"
smartquotes = False

exclude_patterns = ["figures"]

html_theme = "furo"
html_title = "soilsig"
html_theme_options = {"light_css_variables": {"code-font-size": "78%"}}
html_copy_source = False
html_show_copyright = False
html_show_sphinx = False
html_math_renderer = "mathml"


def setup(app):
    """Formulas become MathML, which browsers show without a script from elsewhere."""
    app.add_html_math_renderer("mathml", (inline_math, None), (block_math, None))


def inline_math(writer, node):
    writer.body.append(convert(node.astext()))
    raise nodes.SkipNode


def block_math(writer, node):
    writer.body.append(convert(node.astext(), display="block"))
    raise nodes.SkipNode
