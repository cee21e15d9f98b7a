"""The paper's figures, one module each. Figures of the same shape share a module."""
