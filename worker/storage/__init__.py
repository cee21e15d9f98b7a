"""Where the bytes of stores lie: folders and buckets, files written as a whole, and chunks that are checked."""
