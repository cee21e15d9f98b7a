"""The impact map P: applied, inverted, differentiated, and followed one motion at a time."""
