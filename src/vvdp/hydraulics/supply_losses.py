"""Losses of a supply at steady flow and pressure: power at the pump's shaft minus power at the load.

Every way is counted alike. A pump displaces a flow, loses `G p` of it by leakage, and takes the hydraulic power of what
it displaces; what does not arrive at the load is lost. What drags the pump's shaft comes on top: `drag_power`.

Source  ours, docs/when-switching-pays.md, where a function names no other.
"""


def metered_loss(pump_flow: float, delivered: float, load_rise: float, relief_rise: float) -> float:
    """Power lost when a fixed pump runs at its relief setting and a throttle meters the load's flow [W].

    Q P_R - q P_L, whether a proportional valve or a digital flow control unit is the throttle.

    pump_flow, delivered    Q that the pump displaces, q [m^3/s]
    load_rise, relief_rise  of load and relief setting over the tank, P_L and P_R [Pa]

    Source  wang2017, chapter 1

    >>> metered_loss(40e-3 / 60.0, 20e-3 / 60.0, 100e5, 120e5)  # 8 kW less 3.33 kW
    4666.666666666667
    """
    return pump_flow * relief_rise - delivered * load_rise


def bled_off_loss(pump_flow: float, delivered: float, load_rise: float) -> float:
    """Power lost when a fixed pump runs at load pressure and a throttle bleeds the surplus flow to the tank [W].

    (Q - q) P_L: the best that throttling a fixed pump can do, without any drop on the way to the load.

    pump_flow, delivered  Q that the pump displaces, q [m^3/s]
    load_rise             of the load over the tank, P_L [Pa]
    """
    return (pump_flow - delivered) * load_rise


def load_sensing_loss(delivered: float, load_rise: float, supply_rise: float, leakage: float) -> float:
    """Power lost when a variable pump holds a pressure that a throttle brings down to that of the load [W].

    q (P_S - P_L) + G P_S^2. For load sensing P_S is the highest load with the margin on it: of several actuators at one
    pump the losses of the throttles add up, and what leaks counts once. For a pressure-compensated pump P_S is its
    setting. For displacement control, without any throttle, P_S is P_L.

    delivered               q [m^3/s]
    load_rise, supply_rise  of load and supply over the tank, P_L and P_S [Pa]
    leakage                 G of the pump [m^3/(s Pa)]

    >>> load_sensing_loss(20e-3 / 60.0, 100e5, 120e5, 2e-12)  # 667 W over the throttle, 288 W leak
    954.6666666666666
    """
    return delivered * (supply_rise - load_rise) + leakage * supply_rise * supply_rise


def drag_power(pressure_rise: float, shaft_speed: float, displacement: float, friction: float, share: float) -> float:
    """Power that a pump's shaft takes beyond the hydraulic one [W]: (T_f + c D p) |omega|.

    Displacement is that of the whole pump, also where it is destroked: pistons and vanes rub all the same.

    pressure_rise  p over the pump [Pa]
    shaft_speed    omega [rad/s]
    displacement   D, full [m^3/rad]
    friction       T_f, whatever the pressure [N m]
    share          c, of the full displacement's torque [1]

    >>> round(drag_power(100e5, 188.5, 3.6287e-6, 1.0, 0.03), 1)  # 188.5 W, and 3 % of 6840 W
    393.7
    """
    return (friction + share * displacement * pressure_rise) * abs(shaft_speed)
