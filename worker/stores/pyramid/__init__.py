"""Levels of large basins: what each cell of a level stands for, and how a store says so."""
