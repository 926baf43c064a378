"""Results as JSON documents, with the field names that other programs rely on.

The words of one result are those of its ``to_dict``; here they are put together, and written.
"""

import json
from typing import TYPE_CHECKING, Any

from shakedown.ground.errors import Missing, present
from shakedown.ground.shown_values import plain, visible

if TYPE_CHECKING:
    from shakedown.assessment.assess import Assessment


def as_text(document: dict[str, Any]) -> str:
    """A JSON document as written to files and stdout, without control characters."""
    text = json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False)
    return visible(text, keep="\n", escape=_json_escape)


def _json_escape(character: str) -> str:
    code = ord(character)
    return f"\\u{code:04x}" if code < 0x10000 else json.dumps(character)[1:-1]


def assessment_document(found: "Assessment", *, follow: bool = False) -> dict[str, Any]:
    """What ``shakedown-bounds solve --json`` writes."""
    limits = found.details
    limit = present(limits.transient) if follow else None
    absent = limits.absent | {"friction": limits.friction, "sensitivities": limits.sensitivities["upper"]}
    missing = {word: each.reason for word, each in absent.items() if isinstance(each, Missing)}
    return plain(
        {
            "problem": found.problem,
            "pinned": limits.pinned,
            "assessment": found,
            **limits.to_dict(),
            "mesh": limits.mesh,
            "friction": limits.friction,
            "sensitivities": {name: present(each) for name, each in limits.sensitivities.items()},
            **({"followed": None if limit is None else limit.followed} if follow else {}),
            **({"missing": missing} if missing else {}),
        }
    )


def averaged_document(found: "Assessment", radius: float) -> dict[str, Any]:
    """What is known of slips and reactions averaged over a radius."""
    about = {"radius": radius, "nodes": found.problem.n} | found.to_dict()
    return {"averaged": plain(about)}
