"""The published study end to end: exact envelopes, the network, the indices, and the paper's numbers beside them."""
