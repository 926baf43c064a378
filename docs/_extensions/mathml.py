"""Formulas as MathML, which browsers set themselves: no script, no font and no server is needed."""

import re

from docutils import nodes
from docutils.utils.math import latex2mathml
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

SUBSCRIPT = r"<m[in]>[^<]*</m[in]>|<mrow>.*?</mrow>"
ACCENTED = re.compile(  # docutils puts the subscript of an accented letter below it
    rf'<munderover>\s*(<mi>[^<]*</mi>)\s*({SUBSCRIPT})\s*(<mo stretchy="false">[˙ˆˉ˜~]</mo>)\s*</munderover>',
    re.S,
)


def _set(node: nodes.Node, *, as_block: bool) -> str:
    tree = latex2mathml.tex2mathml(node.astext(), as_block=as_block)
    text = tree if isinstance(tree, str) else "".join(tree)
    return ACCENTED.sub(r'<msub><mover accent="true">\1\3</mover>\2</msub>', text)


def inline(self: HTML5Translator, node: nodes.math) -> None:
    """A formula within a line."""
    self.body.append(_set(node, as_block=False))
    raise nodes.SkipNode


def block(self: HTML5Translator, node: nodes.math_block) -> None:
    """A formula on lines of its own."""
    self.body.append(f'<div class="formula">{_set(node, as_block=True)}</div>\n')
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Read by Sphinx."""
    app.add_html_math_renderer("mathml", (inline, None), (block, None))
    return {"parallel_read_safe": True}
