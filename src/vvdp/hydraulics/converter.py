"""Switched hydraulic converters without losses: pressures, flows and their swing, in closed form.

A valve joins a tube's node to a first pressure for the share d of each period and to a second one for the rest, or a
check valve does; the oil in the tube has the inertance I. Over a period at which it ends as it began, its mean pressure
difference is zero.

Source  ours, docs/when-switching-pays.md, where a function names no other.
"""


def buck_pressure(duty_ratio: float, supply: float, base: float) -> float:
    """Pressure of the load behind the tube while the oil in it never stops [Pa]: d P_s + (1 - d) P_b.

    duty_ratio    d, share of the period at the supply [1]
    supply, base  P_s, and P_b that the check valve draws from [Pa]

    Source  wang2017, section 1.2.1

    >>> buck_pressure(0.25, 200e5, 0.0)
    5000000.0
    """
    return duty_ratio * supply + (1.0 - duty_ratio) * base


def boost_pressure(duty_ratio: float, supply: float, base: float) -> float:
    """Pressure of the load behind the check valve while the oil in the tube never stops [Pa]: (P_s - d P_b)/(1 - d).

    duty_ratio    d, share of the period at the base, below 1 [1]
    supply, base  P_s that feeds the tube, and P_b to which the valve lets it go [Pa]

    Source  wang2017, section 1.2.1

    >>> boost_pressure(0.75, 50e5, 0.0)
    20000000.0
    """
    return (supply - duty_ratio * base) / (1.0 - duty_ratio)


def flow_swing(duty_ratio: float, difference: float, pwm_frequency: float, inertance: float) -> float:
    """Swing of a tube's flow, peak to peak, while it never stops [m^3/s]: d p/(f I).

    duty_ratio     d, share of the period for which the difference drives it [1]
    difference     p over the tube then [Pa]
    pwm_frequency  f [Hz]
    inertance      I, density times length over area [kg/m^4]

    >>> flow_swing(0.5, 100e5, 100.0, 5e7)
    0.001
    """
    return duty_ratio * difference / (pwm_frequency * inertance)


def stopping_buck_flow(swing: float, duty_ratio: float, above: float, below: float) -> float:
    """Mean flow of a buck converter whose tube stops within each period [m^3/s]: d s (1 + a/b)/2.

    It rises by the swing s in the share d of a period, and falls again in d a/b of it; where that is 1 - d the tube
    stops for an instant, and the load is at `buck_pressure`.

    swing         s; see `flow_swing` [m^3/s]
    duty_ratio    d [1]
    above, below  a of the supply above the load, b of the load above the base [Pa]

    >>> stopping_buck_flow(0.001, 0.5, 100e5, 100e5)
    0.0005
    """
    return 0.5 * swing * duty_ratio * (1.0 + above / below)
