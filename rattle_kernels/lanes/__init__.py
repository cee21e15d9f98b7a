"""The impact map for 64 states at once, in loops that LLVM turns into vector code."""
