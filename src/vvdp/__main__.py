"""`python -m vvdp` is `vvdp`."""

import sys

if not sys.flags.safe_path:  # as for the script `vvdp`: nothing is imported from the working folder
    del sys.path[0]

from vvdp.cli.main import main

main()
