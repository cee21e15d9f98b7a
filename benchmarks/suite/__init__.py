"""The suite: how fast gears are followed, by this project and by others, on the same inputs.

``python -m benchmarks.suite`` runs it. docs/benchmarks.md says what is counted, and how others report their numbers.
"""
