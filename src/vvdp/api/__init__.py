"""The public interface, `import vvdp`: systems and runs with everything that a script or a notebook needs of them."""
