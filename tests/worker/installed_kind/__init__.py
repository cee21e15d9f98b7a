"""A package that adds a kind of jobs, as it would lie in a repository of its own."""
