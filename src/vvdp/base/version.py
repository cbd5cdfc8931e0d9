"""Version of vvdp, which results name and by which stored cases are recognised."""

VERSION = "0.1.0"
