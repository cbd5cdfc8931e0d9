"""What vvdp holds, in the forms that other programs read."""
