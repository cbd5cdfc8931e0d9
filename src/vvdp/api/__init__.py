"""What `import vvdp` offers: systems and runs with everything that a script or a notebook asks of them."""
