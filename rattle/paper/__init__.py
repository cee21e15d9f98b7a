"""The figures of the paper, recomputed: one module per figure, and the code they share.

`registry` lists the figures, and `production` computes one of them into a folder. A figure names the basins it needs.
The pipeline computes these into stores, which are shared and can be resumed. The figure turns them into a sheet.
"""
