"""Options by which commands name an oscillator."""

from typing import Annotated

import typer

from rattle_kernels import Oscillator
from service.models.oscillator import PermanentContact

Damping = Annotated[float, typer.Option(help="delta")]
Eccentricity = Annotated[float, typer.Option(help="epsilon, below the bounds of Eqs. (3) and (8)")]
HalfBacklash = Annotated[float, typer.Option(help="beta")]
Stiffness = Annotated[float | None, typer.Option(help="kappa; without it, the impacting model")]
Rule = Annotated[PermanentContact, typer.Option("--permanent-contact", help="When a contact counts as permanent")]
AllowNoQuietSolution = Annotated[bool, typer.Option("--allow-no-quiet-solution", help="Go beyond the bound of Eq. (3)")]


def oscillator_of(
    damping: float, eccentricity: float, half_backlash: float, stiffness: float | None, rule: PermanentContact
) -> Oscillator:
    """Oscillator that the options name, not checked yet."""
    if stiffness is None:
        return Oscillator(damping, eccentricity, half_backlash)
    return Oscillator(damping, eccentricity, half_backlash, stiffness, rule.permanent_after)
