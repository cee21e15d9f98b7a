"""The paper's figures, one module each; figures of one shape share theirs."""
