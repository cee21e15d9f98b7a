"""Charts of two parameters, beside `rattle`: where motions are born, double, graze and end, and what organises it.

Floors, the highest first; each imports from lower ones alone ::

    command
    chart | kind
    analysis
    job
"""

COMMAND = (
    "rattle_chart.command:chart",
    "Chart two parameters: curves of special points, points of codimension two, and what machines do.",
    (
        "rattle chart --damping 0.75:0.78 --eccentricity 0.094:0.0995 --half-backlash 0.6 --out c.zarr",
        "rattle chart --damping 0.5:0.7 --eccentricity 0.08:0.12 --out wide.zarr",
    ),
)
"""``rattle chart``: the entry point `chart` of `rattle.commands` names it."""
