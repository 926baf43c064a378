"""The drawing of the page *Architecture*; run as a script, this file writes _static/data-flow.svg."""

import sys
from pathlib import Path

SVG = Path(__file__).parents[1] / "_static" / "data-flow.svg"
WIDTH, HEIGHT = 800, 575
BOX = (172, 58)
BOXES = {  # name: (column centre, row centre, title, what it makes, colour)
    "importing": (100, 45, "models.importing, readers", "TOML and FE output", "#e8eef7"),
    "fem": (300, 45, "fem", "meshes, bodies", "#e8eef7"),
    "files": (500, 45, "files", "NPZ, built-in joints", "#e8eef7"),
    "script": (700, 45, "your script", "arrays", "#ffffff"),
    "condensation": (200, 145, "models.condensation", "K → A, B, C", "#e8eef7"),
    "joint": (500, 195, "joint", "Problem; rows, cones, law", "#fdf1d8"),
    "programs": (100, 245, "programs", "linear, cone, exact", "#eeeeee"),
    "bounds": (300, 300, "bounds", "λ_max, λ_E, λ_1, λ_U", "#e2f1e4"),
    "motion": (700, 300, "motion", "the exact path", "#e2f1e4"),
    "long_term": (700, 390, "long_term", "what it settles into", "#e2f1e4"),
    "assessment": (300, 390, "assessment", "each limit, once", "#e2f1e4"),
    "verification": (500, 450, "verify, studies", "prediction beside motion", "#e2f1e4"),
    "report": (500, 535, "report, plot, cli", "words, pictures, JSON", "#f6e3ee"),
}
ARROWS = [
    ("importing", "condensation"),
    ("fem", "condensation"),
    ("files", "joint"),
    ("script", "joint"),
    ("condensation", "joint"),
    ("joint", "bounds"),
    ("programs", "bounds"),
    ("joint", "motion"),
    ("motion", "long_term"),
    ("bounds", "assessment"),
    ("long_term", "assessment"),
    ("assessment", "verification"),
    ("long_term", "verification"),
    ("verification", "report"),
]


def edge(name: str, towards: tuple[float, float]) -> tuple[float, float]:
    """Where the line from the middle of a box to a point leaves the box."""
    x, y = BOXES[name][:2]
    dx, dy = towards[0] - x, towards[1] - y
    share = min(
        BOX[0] / 2 / abs(dx) if dx else float("inf"),
        BOX[1] / 2 / abs(dy) if dy else float("inf"),
    )
    return x + share * dx, y + share * dy


def drawn_box(name: str) -> str:
    """A box with its two lines."""
    x, y, title, makes, colour = BOXES[name]
    return (
        f'<rect x="{x - BOX[0] / 2:g}" y="{y - BOX[1] / 2:g}" width="{BOX[0]}" height="{BOX[1]}" rx="6" '
        f'fill="{colour}" stroke="#445"/>'
        f'<text x="{x}" y="{y - 4}" text-anchor="middle" font-weight="600">{title}</text>'
        f'<text x="{x}" y="{y + 15}" text-anchor="middle" font-size="12">{makes}</text>'
    )


def drawn_arrow(start: str, end: str) -> str:
    """From border to border."""
    (x0, y0), (x1, y1) = edge(start, BOXES[end][:2]), edge(end, BOXES[start][:2])
    return f'<line x1="{x0:.1f}" y1="{y0:.1f}" x2="{x1:.1f}" y2="{y1:.1f}" marker-end="url(#tip)"/>'


def drawing() -> str:
    """The whole drawing."""
    arrows = "\n".join(drawn_arrow(*arrow) for arrow in ARROWS)
    boxes = "\n".join(drawn_box(name) for name in BOXES)
    return f"""<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img"
 font-family="system-ui, sans-serif" font-size="13" fill="#112">
<title>How data flow through the package</title>
<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>
<defs><marker id="tip" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="8" markerHeight="8" orient="auto">
<path d="M0 1 L9 5 L0 9 z" fill="#445"/></marker></defs>
<g stroke="#445" stroke-width="1.3" fill="none">
{arrows}
</g>
{boxes}
</svg>
"""


if __name__ == "__main__":
    SVG.write_text(drawing(), encoding="utf-8")
    sys.exit(0)
