"""Studies of a machine in its own units, beside `rattle`: how often it rattles, from which value on, which tolerance.

What they compute with is what any user has: `rattle`, and the public names of `rattle_kernels`. A report is a kind of
job besides, as `worker.kinds` has them. A proof is asked of `rattle_proof`, where that is installed.

Floors, the highest first; each imports from lower ones alone ::

    command
    report | kind
    routes
    analysis
    job | page
    threshold | tolerances
    departures | proven
    parameter_box | pulses
    estimates | numbers
"""

PULSES = (
    "rattle_machine.command:pulses",
    "How often torque pulses make a quiet machine rattle, for how long, and with what power.",
    (
        'rattle pulses machine.toml --rate "3 / hour" --size "0.05 N m s"',
        'rattle pulses machine.toml --rate "3 / hour" --size measured.csv',
    ),
)
"""``rattle pulses``: the entry point `pulses` of `rattle.commands` names it."""

THRESHOLD = (
    "rattle_machine.command:threshold",
    "The value of a machine's parameter at which a share of quiet, or of another motion, is reached.",
    (
        'rattle threshold machine.toml backlash --share 0.9 --between "40 um" "200 um"',
        "rattle threshold machine.toml speed --share 0.99 --between 600rpm 3000rpm",
    ),
)
"""``rattle threshold``: the entry point `threshold` of `rattle.commands` names it."""

TOLERANCES = (
    "rattle_machine.command:tolerances",
    "How quiet the machines of a production are, and which tolerance is to blame for those that are not.",
    (
        'rattle tolerances machine.toml --number "backlash=120 +- 40 um"',
        'rattle tolerances machine.toml --number "backlash=120 +- 40 um, normal"',
    ),
)
"""``rattle tolerances``: the entry point `tolerances` of `rattle.commands` names it."""

REPORT = (
    "rattle_machine.command:report",
    "Write one page that prints: what a machine does, how loud, how often, and which tolerance is to blame.",
    (
        "rattle report machine.toml --out report.html",
        'rattle report machine.toml --rate "3 / hour" --size "2 mN m s"',
    ),
)
"""``rattle report``: the entry point `report` of `rattle.commands` names it."""
