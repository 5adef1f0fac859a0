"""``python -m gtm_fmu``: the command line `gtm-fmu`.

This file is the one of the package that knows the command line, which lies above it; nothing imports it.
"""

from gtm_study.commands.cli import main

if __name__ == "__main__":
    main()
