"""What must stay the same: requests, digests, stores, answers and commands, as files to compare with."""
