"""Laws of the valve fitted to tables from flow simulation or from a rig."""
