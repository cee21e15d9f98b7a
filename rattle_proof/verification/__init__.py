"""A proof in a store is proven again, by other means than the kernels: Arb balls, and the theorem alone."""
