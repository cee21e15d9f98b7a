"""The backlash oscillator: its equations of motion, and their closed form between events."""
