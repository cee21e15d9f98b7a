"""The paper's figures, recomputed: one module a figure, and what they share.

`registry` lists them, `production` computes one into a folder. A figure names the basins that it needs, which the
pipeline computes into stores that are resumed and shared; from these it draws a sheet and sums it up in numbers.
"""
