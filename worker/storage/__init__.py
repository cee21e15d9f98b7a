"""Where the bytes of stores lie: folders and buckets, files written as a whole, and chunks that are checked.

Floors, the highest first; each imports from lower ones alone ::

    chunks
    location
    folder | object_storage
    checked_chunks | protocol
"""
