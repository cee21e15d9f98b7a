"""What every request and answer passes: limits, authentication, headers, metrics."""
