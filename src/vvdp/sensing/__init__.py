"""The coarse encoder: code wheel, light spot, comparator, sampling, faults."""
