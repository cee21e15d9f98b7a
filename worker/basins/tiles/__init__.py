"""Tiles at work: what a process keeps of them, and how long they take."""
