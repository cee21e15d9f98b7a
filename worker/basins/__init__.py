"""From the job of a basin or a sweep to its finished store.

Floors, the highest first; each imports from lower ones alone ::

    pipeline
    schedule
    ledger
    whole_basin | numbering
    basin_run | coarsening
    tasks
    assembly | image_cache | weights
"""
