"""The published study: its numbers, our counterparts, comparison and report."""
