"""Numerics that know no mechanics: compiling, roots, polynomials, curves of solutions, phases."""
