"""The figures of the paper, recomputed, beside `rattle`: one module per figure, and the code they share.

`registry` lists the figures, and `production` computes one of them into a folder. A figure names the basins it needs.
`rattle.compute` computes these into stores, which are shared and can be resumed. The figure turns them into a sheet.
All of it uses what any user has: `rattle`, `rattle.pictures` and the public names of `rattle_kernels`.
"""

COMMAND = (
    "rattle_paper.command:paper",
    "Recompute a figure of the paper and its numbers; basins that are there already are used, unfinished resumed.",
    ("rattle paper fig7 --out paper", "rattle paper fig7 --cells 200 200 --out quick"),
)
"""``rattle paper``: the entry point `paper` of `rattle.commands` names it."""
