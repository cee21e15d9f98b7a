"""Panels that figures are made of, and what they show."""
