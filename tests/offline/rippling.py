"""A spool whose speed ripples with its angle, by the closed form of its passing times."""

import numpy as np

TURN = 2.0 * np.pi


def passing_times(angles, order, amplitude, speed):
    """When the spool is at `angles` [rad] if its speed is speed (1 + amplitude cos(order angle)), 0 at angle 0 [s].

    The integral of d theta/(1 + a cos N theta), by the tangent of half the angle over whole waves and the rest of one.
    """
    waves, rest = np.divmod(order * np.asarray(angles) + np.pi, TURN)
    root = np.sqrt((1.0 - amplitude) / (1.0 + amplitude))
    half = np.arctan(root * np.tan(0.5 * (rest - np.pi)))
    return (TURN * waves + 2.0 * half) / (order * speed * np.sqrt(1.0 - amplitude**2))
