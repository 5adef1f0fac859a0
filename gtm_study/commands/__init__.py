"""The command line `gtm-fmu`, a module a group of commands."""
