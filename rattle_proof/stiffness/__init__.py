"""Motions of the piecewise linear model that attract, by proof: permanent contact and periodic orbits, in Arb balls.

Floors, the highest first; each imports from lower ones alone ::

    orbit_disc | permanent_contact
    impact_map
    contact
"""
