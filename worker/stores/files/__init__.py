"""Files of stores: when they are on the disk, and whether their bytes are those that were written."""
