"""The study of the impaired GTM-T2 from end to end, and the command line."""
