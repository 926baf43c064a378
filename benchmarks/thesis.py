"""The thesis equation by equation, printed beside computed: ``python -m benchmarks.thesis`` writes the page.

The page is ``docs/thesis.md``; its pictures of chapter III are those of the study ``receding``.
"""

import sys
from pathlib import Path

from benchmarks import thesis_chapter_6, thesis_chapters
from benchmarks.thesis_entry import Entry, markdown

PAGE = Path(__file__).parents[1] / "docs" / "thesis.md"
HEAD = """# The thesis, line by line

Y. J. Ahn, *Response of Coupled Frictional Contacts to Cyclic Loading*, PhD thesis, University of
Michigan, 2009: where its equations and figures are in this toolkit, and its printed numbers beside
computed ones. `python -m benchmarks.thesis` writes this page. Pictures of chapter
III are those of the study `receding`, all others of `python -m benchmarks reaction_planes worked_examples`
at commit fdca7323.

Tables with a column "printed" compare the numbers that the thesis prints (0 where it prints "none"); the
others list what has no printed number. "Difference" is the largest relative one; "same digits": every
computed number rounds to the one printed. "Another block": [see below](#why-some-numbers-differ). The thesis
numbers nodes from 1, the toolkit from 0; I, II are the backward and the forward limit of node 0, III, IV
those of node 1.
"""
TAIL = """## Why some numbers differ

- **Chapter III.** The mesh is not printed; here the right half of the contact has 97 nodes. With 193 the
  exponents are −3.09 and −3.11, and the dissipation 0.554 (`python -m benchmarks receding`). In the ninth
  cycle the outermost nodes of the inner slip region slip again in the last 2 % of the reloading.
- **5.4: another block.** The thesis prints neither the angle of the plane, nor where the pressure acts,
  nor matrices. λ_max is a limit with all nodes in contact: from zero slip our block also comes to rest above
  λ_max, with seven of its nine nodes open.
- **Chapter VI.** The matrices (6.45) are printed with four digits; the thesis computed with more. So the
  discontinuity point differs in the fourth digit, the end state by 0.5 %. The smaller eigenvalue of H
  depends on a difference of nearly equal numbers; four digits of the matrices give it to about 3 %.

## Misprints of the thesis

| where | printed | must be |
|---|---|---|
| (2.12) | B = Bᵀ | B is a general matrix: in its own two-node system B ≠ Bᵀ |
| (4.21) | sign of the first term | −f p |
| (5.4) | min and max | the other way round, as in (4.24) |
| (5.8), (5.10) | signs of the forward line, through (q⁰, p⁰) | q + f p − (f p⁰ + q⁰) = 0 |
| (6.9) | last term −(B₁₁B₂₂ + B₁₂B₂₁) f² | −(B₁₁B₂₂ − B₁₂B₂₁) f²; the printed sign gives 0.3505, not 0.3557 |
| (6.22) | D₃₃ | D₂₂ |
| after (6.31) | A₁₁ − fB₁₁ > 0 | A₁₁ + fB₁₁ > 0 |
| (6.37), last row | B₂₂ δw₂ | C₂₂ δw₂, as in (6.40) |
| after (6.47) | A₂₂ + fB₂₂ > 0 | A₂₂ − fB₂₂ > 0 for the limits II and III, as in (6.10) |
| (6.56) | eigenvalues of G | eigenvalues of −G |
| (6.59) | (24.27, −55.42, 3.33) | (24.2755, −55.4279) = (6.60) − (6.49); (6.58) · P* gives w₂ = 3.345 |

## Our choices

- Chapters III and V: plane strain and the meshes; in 5.4 the angle and where the pressure acts.
- 5.3: fifty load steps. No other number from 8 to 2,000 gives all four printed load factors; in the limit
  they are 0.6572, 0.7389, 1.0520, 2.9297.
- 6.4: the load path to the discontinuity. Both nodes start stuck at q₁ = 2.6, which falls to the 2.5 of
  (6.48).
- Appendix A: the stiffnesses and the loops. It has only drawings, with F = −(q_w, p_w).
- (4.14)–(4.17): L_j = [A_j; B_j], rows of node j, is inferred from the product.

Figures 2.1, 4.1, 4.10–4.12, 6.1–6.4, A.1–A.3 and A.5 are not drawn: we do not know what they show.
"""


def page() -> str:
    """The text of the page."""
    parts = [HEAD]
    for title, entries in sections().items():
        parts.append(f"## {title}\n\n{markdown(entries)}\n")
    return "\n".join([*parts, TAIL])


def sections() -> dict[str, list[Entry]]:
    """Every line of every chapter."""
    return {
        "II. The discrete system": thesis_chapters.chapter_2(),
        "III. Receding contact": thesis_chapters.chapter_3(),
        "IV. One and two nodes": thesis_chapters.chapter_4(),
        "V. Load factors": thesis_chapters.chapter_5(),
        "VI. Discontinuities": thesis_chapter_6.chapter_6(),
        "Appendix A. One node": thesis_chapter_6.appendix_a(),
        "Conjectures and open questions": thesis_chapters.conjectures(),
    }


def main() -> int:
    PAGE.write_text(page(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
