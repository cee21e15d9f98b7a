"""Examples of each command, which its help ends with."""

_EXAMPLES: dict[str, tuple[str, ...]] = {
    "rattle": ("rattle basin --out basin.zarr", "rattle plot basin.zarr --out basin.png"),
    "serve": ("rattle serve --data runs --workers 8", "rattle serve --scheduler tcp://host:8786"),
    "basin": (
        "rattle basin --damping 0.6 --eccentricity 0.1 --out basin.zarr",
        "rattle basin --cells 200 150 --velocity 0 5 --out small.zarr",
        "rattle basin --sample 100000 --out shares.zarr",
    ),
    "sweep": (
        "rattle sweep --vary damping=0.5:0.7:21 --cells 100 --out sweep.zarr",
        "rattle sweep --vary half-backlash=0.5,0.6,0.7 --out sweep.zarr",
    ),
    "bifurcation": ("rattle bifurcation --vary damping=0.5:0.6:201 --seed 0.6,3.77 --out b.zarr",),
    "orbits": (
        "rattle orbits --longest 3 --out orbits.zarr",
        "rattle orbits --follow damping=0.45:0.7 --out branches.zarr",
    ),
    "manifold": ("rattle manifold --saddle 0.6017,3.7699 --arclength 20 --out manifold.zarr",),
    "grazing-curve": ("rattle grazing-curve --order 4 --out grazing.zarr",),
    "trajectory": ("rattle trajectory --velocity 3.77 --time 0.6 --out motion.png",),
    "transmission-error": ("rattle transmission-error te.csv --unit degrees --scale 0.01",),
    "paper": ("rattle paper fig7 --out paper", "rattle paper fig7 --cells 200 200 --out quick"),
    "submit": ("rattle submit request.json --wait", "rattle submit - --json < request.json"),
    "jobs": ("rattle jobs --limit 50", "rattle jobs --json"),
    "status": ("rattle status 3f2a",),
    "fetch": ("rattle fetch 3f2a --out basin.zarr",),
    "cancel": ("rattle cancel 3f2a",),
    "delete": ("rattle delete 3f2a",),
    "check": ("rattle check basin.zarr --dry-run", "rattle check s3://results/basin.zarr"),
    "export": ("rattle export basin.zarr --zip basin.zip",),
    "verify": ("rattle verify basin.zarr --cells 1000", "rattle verify basin.zarr --boxes all"),
    "keys": ("rattle keys add alice", "rattle keys list"),
    "add": ("rattle keys add alice", "rattle keys add monitor --scope read"),
    "list": ("rattle keys list --json",),
    "revoke": ("rattle keys revoke alice",),
    "certs": ("rattle certs certificates --days 365",),
    "plot": ("rattle plot basin.zarr --out basin.png", "rattle plot sweep.zarr --shares --out shares.svg"),
    "table": ("rattle table basin.zarr", "rattle table orbits.zarr --name orbit --out orbits.csv"),
}


def examples_of(name: str) -> tuple[str, ...]:
    """Lines that call a command.

    Parameters
    ----------
    name : str
        Last word of the command; ``rattle`` for all of them.

    Returns
    -------
    tuple of str
    """
    return _EXAMPLES.get(name, ())


def epilog_of(name: str) -> str | None:
    """What the help of a command ends with.

    Parameters
    ----------
    name : str

    Returns
    -------
    str or None
    """
    lines = examples_of(name)
    return "\n\n".join(("Examples:" if len(lines) > 1 else "Example:", *lines)) if lines else None
