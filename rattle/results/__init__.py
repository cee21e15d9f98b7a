"""Results as datasets: opened, kept, drawn, measured and listed."""
