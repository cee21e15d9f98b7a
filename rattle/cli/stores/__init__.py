"""The commands on whole stores."""
