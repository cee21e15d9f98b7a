"""What the page says of a proof: its box, its layer, its words; ``service/explorer/types.d.ts`` has the shape."""

from rattle_proof.enclosures.cells import WHOLE
from rattle_proof.layout import Unproven

_REASONS = {
    Unproven.ARRIVES_NOWHERE: "comes to no proven place",
    Unproven.SPREADS: "spreads too wide to be followed",
    Unproven.GRAZES: "straddles grazing: some departures strike −β, others miss it",
    Unproven.ENDS_ELSEWHERE: "is proven to end otherwise in part",
    Unproven.RATTLES: "never falls quiet, but in which motion it ends is not proven",
}
PAGE = {
    "name": "prove",
    "outline": "proof",
    "box": {
        "label": "prove it",
        "title": "Of each cell, that every departure in it ends as it is coloured. It takes longer.",
        "model": "impacting",
    },
    "address": {"number": "levels", "pairs": "tolerances", "pair": "tolerance"},
    "stages": {"enclosing": "growing the lattice that cells are proven from", "proving": "proving cells"},
    "mask": {
        "name": "proven",
        "label": "Proven",
        "sign": "M2 2L14 14 M9 2L21 14 M16 2L25 11",
        "colour": "#d9d9d9",
        "note": "Pale and hatched is what is not proven. Elsewhere every departure of a cell is shown to end as it is "
        "coloured.",
        "parts": WHOLE,
        "words": {
            "clear": "Proven",
            "veiled": "Not proven",
            "whole": "Proven: every departure of this cell {ends}.",
            "partly": f"Proven for {{parts}} of {WHOLE} parts of this cell. The rest {{reason}}.",
            "none": "Not proven: this cell {reason}.",
            "untried": "Not proven: it was not tried yet.",
        },
        "ends": {
            "permanent_contact": "falls quiet",
            "chaotic": "comes to rattle for ever, in a region that it never leaves",
        },
        "reasons": {str(int(reason)): words for reason, words in _REASONS.items()},
    },
}
