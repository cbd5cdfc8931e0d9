"""vvdp: virtually variable displacement pumps and other digital hydraulics."""

__version__ = "0.1.0"
