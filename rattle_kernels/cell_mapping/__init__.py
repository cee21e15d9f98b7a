"""Hsu's cell mapping: grid, images, groups, periods and steps."""
