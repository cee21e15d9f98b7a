"""The command line: ``rattle COMMAND``."""

import typer

from service.cli import analyses, compute, local, paper, remote, trajectory

app = typer.Typer(
    name="rattle",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    help="Which motion does a rattling gear end in? Basins of attraction of a backlash oscillator.\n\n"
    "Alone: `rattle basin` computes one here, `rattle sweep` many, `rattle plot` draws them; "
    "`rattle bifurcation`, `rattle orbits`, `rattle manifold` and `rattle grazing-curve` explain them; "
    "`rattle trajectory` follows one motion, `rattle paper` recomputes a figure of the paper. "
    "With a service: `rattle serve` starts one, "
    "`rattle submit` sends it a request, `rattle jobs` and `rattle cancel` follow and stop what it does.",
)
app.command()(local.serve)
app.command()(compute.basin)
app.command()(compute.sweep)
app.command()(analyses.bifurcation)
app.command()(analyses.orbits)
app.command()(analyses.manifold)
app.command()(analyses.grazing_curve)
app.command()(trajectory.trajectory)
app.command()(paper.paper)
app.command()(remote.submit)
app.command()(remote.jobs)
app.command()(remote.cancel)
app.command()(local.plot)
