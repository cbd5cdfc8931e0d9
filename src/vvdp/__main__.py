"""`python -m vvdp` is `vvdp`."""

from vvdp.cli.main import main

main()
