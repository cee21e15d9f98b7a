"""What all tests share."""

from hypothesis import settings

# The first call of a kernel compiles it; the limit per test is pytest-timeout's.
settings.register_profile("rattle", deadline=None, derandomize=True)
settings.load_profile("rattle")
