"""The page docs/models/passivity-control.md, derived symbolically: for any bulk modulus, any volume, any trajectory.

The oil is known by three functions of the pressure alone: beta, G with G' = 1/beta, so that g(P, P') = G(P) - G(P'),
and I with I' = e^-G, so that W_V = e^G(P) (I(P) - I(P_d)) - (P - P_d).
"""

import pytest

sympy = pytest.importorskip("sympy")

t, M, A, K, F0, V0, P0 = sympy.symbols("t M A K F_0 V_0 P_0", positive=True)
x, m, P, Pd, r = (sympy.Function(name)(t) for name in ("x", "m", "P", "P_d", "r"))
Q, q = sympy.symbols("Q q")
beta, G, integral, w, level = (sympy.Function(name) for name in ("beta", "G", "I", "w", "P"))
V = V0 + A * x
v = x.diff(t)


def of_oil(expression):
    """Derivatives of G and I replaced by what they are."""
    for function, slope in ((G, lambda p: 1 / beta(p)), (integral, lambda p: sympy.exp(-G(p)))):
        for p in (P, Pd):
            expression = expression.subs(sympy.Derivative(function(p), p), slope(p))
    return expression


def stored():
    """W_V(P, P_d)."""
    return sympy.exp(G(P)) * (integral(P) - integral(Pd)) - (P - Pd)


PRESSURE = beta(P) / V * (Q - A * v)
RISE = sympy.exp(G(P) - G(Pd)) - 1


def rate(expression):
    """Along the motion of the plant, whose pressure obeys P' = beta/V (Q - A x')."""
    return of_oil(expression.diff(t)).subs(P.diff(t), PRESSURE)


def test_force_of_the_oil_is_a_slope_of_its_energy():
    """L = M x'^2/2 - K x^2/2 - F_0 x - m w(m/V), w' = (P - P_0)/rho^2: Lagrange's equation is the force balance."""
    rho = sympy.Symbol("rho", positive=True)
    lagrangian = M * v**2 / 2 - K * x**2 / 2 - F0 * x - m * w(m / V)
    slope = (level(rho) - P0) / rho**2
    equation = lagrangian.diff(v).diff(t) - lagrangian.diff(x)
    equation = equation.replace(sympy.Subs, lambda e, old, new: slope.subs(rho, new[0]))
    balance = M * x.diff(t, 2) + K * x + F0 - A * (level(m / V) - P0)
    assert sympy.simplify(equation - balance) == 0


def test_effort_at_the_port_is_pressure_and_stored_energy():
    """The oil's energy grows with mass by w + (P - P_0)/rho: the flow Q = m'/rho brings (P - P_0 + W_V) Q."""
    mass, volume, rho = sympy.symbols("mass V rho", positive=True)
    effort = (mass * w(mass / volume)).diff(mass)
    effort = effort.replace(sympy.Subs, lambda e, old, new: ((level(rho) - P0) / rho**2).subs(rho, new[0]))
    density = mass / volume
    assert sympy.simplify(effort - (w(density) + (level(density) - P0) / density)) == 0


def test_pressure_dynamics_are_the_conservation_of_mass():
    """P(m/V) with dP/drho = beta/rho and m' = rho Q."""
    rho = sympy.Symbol("rho", positive=True)
    found = level(m / V).diff(t)
    found = found.replace(sympy.Subs, lambda e, old, new: (beta(level(rho)) / rho).subs(rho, new[0]))
    found = found.subs(m.diff(t), m / V * Q)
    assert sympy.simplify(found - beta(level(m / V)) / V * (Q - A * v)) == 0


def test_rate_of_the_pressure_storage():
    """(5.25)."""
    p = P - Pd
    expected = (p + stored()) * Q - p * A * v - V * RISE * Pd.diff(t)
    assert sympy.simplify(rate(V * stored()) - expected) == 0


def test_exact_feedforward_leaves_the_two_ports():
    """With Q = Q_d + q, Q_d = (A r + V/B P_d')/(1 + W_V/p): the rate is (p + W_V) q - p A e_v, whatever the gains."""
    p = P - Pd
    feedforward = (A * r + V * RISE / p * Pd.diff(t)) / (1 + stored() / p)
    expected = (p + stored()) * q - p * A * (v - r)
    assert sympy.simplify(rate(V * stored()).subs(Q, feedforward + q) - expected) == 0


def test_published_feedforward_leaves_a_rest():
    p = P - Pd
    feedforward = A * r + V / beta(Pd) * Pd.diff(t)
    expected = (p + stored()) * q - p * A * (v - r)
    rest = sympy.simplify(rate(V * stored()).subs(Q, feedforward + q) - expected)
    by_hand = p * V * (1 / beta(Pd) - RISE / p) * Pd.diff(t) + stored() * feedforward
    assert sympy.simplify(rest - by_hand) == 0
    assert rest != 0


l, Kp, Kv, b = sympy.symbols("lambda_p K_p K_v b", positive=True)
e, ev, p_ = sympy.symbols("e e_v p")


def velocity_error_rate(*disturbance):
    """e_v' as the desired pressure makes it, (5.30), with the friction b that the law makes up for."""
    return (-(K + Kp) * e - Kv * ev - b * (ev - l * e) + A * p_ + sum(disturbance)) / M


def test_desired_pressure_leaves_these_errors():
    """(5.30) from the balance of forces and P_d, with b x_d' in it: what is left of the friction is -b e'."""
    xd, vd, ad = sympy.symbols("x_d v_d a_d")
    position, velocity = xd + e, vd + ev - l * e
    de = velocity - vd
    desired = P0 + (M * (ad - l * de) + b * vd + K * xd + F0 - Kp * e - Kv * ev) / A
    acceleration = (A * (desired + p_ - P0) - K * position - F0 - b * velocity) / M
    assert sympy.simplify(acceleration - ad + l * de - velocity_error_rate()) == 0


def test_storage_of_the_loop_falls_by_gains_and_friction():
    """(5.33): W' - W_P' = -K_v e_v^2 - l (K + K_p) e^2 - b e_v e' + p A e_v; definite for b l < 4 (K + K_p)."""
    de = ev - l * e
    found = M * ev * velocity_error_rate() + (K + Kp) * e * de - p_ * A * ev
    assert sympy.expand(found - (-Kv * ev**2 - l * (K + Kp) * e**2 - b * ev * de)) == 0
    damping = -sympy.hessian(found, (e, ev)) / 2
    share = sympy.Symbol("s", positive=True)
    determinant = sympy.factor(damping.det().subs(b, 4 * (K + Kp) / (l * (1 + share))))
    assert sympy.ask(sympy.Q.positive(determinant))
    assert damping[1, 1] == b + Kv


def test_rate_of_the_desired_pressure_has_these_factors():
    """(5.31): A P_d' = M (x_d''' - l e'') + b x_d'' + K x_d' - K_p e' - K_v e_v'."""
    dev = velocity_error_rate()
    de = ev - l * e
    f = (-M * l * (dev - l * de) - Kp * de - Kv * dev) / A
    alpha_e = ((M * l + Kv) * (K + Kp - b * l) / M - l * (M * l**2 - Kp)) / A
    alpha_ev = ((M * l + Kv) * (Kv + b) / M + M * l**2 - Kp) / A
    assert sympy.simplify(f - (alpha_e * e + alpha_ev * ev - (l + Kv / M) * p_)) == 0


def test_an_estimate_adds_its_errors_to_the_rate():
    """(5.60) in (5.62): alpha_1 = (M l + K_v) K/(M A) of e_1, alpha_2 = (M l + K_v)/A of e_2'."""
    e1, de2 = sympy.symbols("e_1 de_2")
    dev = velocity_error_rate(-M * de2, -K * e1)
    de = ev - l * e
    f = (-M * l * (dev - l * de) - Kp * de - Kv * dev) / A
    assert sympy.simplify(f.diff(e1) - (M * l + Kv) * K / (M * A)) == 0
    assert sympy.simplify(f.diff(de2) - (M * l + Kv) / A) == 0


def test_storage_with_an_estimated_volume_has_two_more_terms():
    """V(x_est) W_V: -A e_2 (p + W_V) + (V_est/V - 1)(p + W_V)(Q - A x') beside the published ones."""
    estimate = sympy.Function("x_est")(t)
    p, V_est = P - Pd, V0 + A * estimate
    published = (p + stored()) * Q - p * A * estimate.diff(t) - V_est * RISE * Pd.diff(t)
    more = (p + stored()) * (-A * (v - estimate.diff(t)) + (V_est / V - 1) * (Q - A * v))
    assert sympy.simplify(rate(V_est * stored()) - published - more) == 0
