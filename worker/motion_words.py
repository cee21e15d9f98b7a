"""What chaotic transients end in, in words. No kernels are loaded for commands that only read a result."""

from collections.abc import Sequence


def ends_in_words(ends: Sequence[tuple[int, float]], names: Sequence[str]) -> str:
    """What a chaotic transient ends in, the most frequent first; empty if that is not known.

    Parameters
    ----------
    ends : sequence of (int, float)
        Numbers of solutions, and the share of the transient's ensemble that ended in each.
    names : sequence of str
        Names of solutions by number.

    Returns
    -------
    str
        With shares, unless all of the ensemble ended in the same.

    Examples
    --------
    >>> ends_in_words([(1, 1.0)], ["permanent contact", "P(4,4,2)"])
    'ends in P(4,4,2)'
    >>> ends_in_words([(0, 0.25), (1, 0.5)], ["permanent contact", "P(4,4,2)"])
    'ends in P(4,4,2) (50 %), permanent contact (25 %); 25 % had not ended'
    """
    if not ends:
        return ""
    if len(ends) == 1 and ends[0][1] == 1.0:
        return f"ends in {names[ends[0][0]]}"
    by_share = sorted(ends, key=lambda end: (-end[1], end[0]))
    listed = ", ".join(f"{names[number]} ({100.0 * share:.0f} %)" for number, share in by_share)
    going = 100.0 * (1.0 - sum(share for _, share in ends))
    return f"ends in {listed}" + (f"; {going:.0f} % had not ended" if going > 0.0 else "")
