/* The bench with an orifice load and its explicit stepper, written by hand: what the compiled circuit is measured against.
 *
 * The places of all values in the flat vectors (P_ parameters, Y_ state, U_ command) and the coefficients
 * of the method come from layout.h, which against_c.py writes from the system itself. Everything prescribed is
 * constant here. The formulas are those of the components of the bench, the stepper that of
 * vvdp.simulation.loop; comments there are not repeated. */
#include <math.h>
#include <string.h>
#include "layout.h"

#define PI 3.14159265358979323846
#define STILL_FLOW 1e-11
#define CAVITATION_NUMBER 0.4
#define LAMINAR_SHARE 0.01
#define RAREFIED 0.01
#define P(name) (p[P_##name])
#define U(name) (u[U_##name])
#define Y(name) (y[Y_##name])

typedef struct { double ratio, modulus, enthalpy; } Fluid;
typedef struct { double flow, loss; } Passage;
typedef struct { double flow, full, nozzle, centre, outlet; } Branch;

static inline double least(double a, double b) { return a < b ? a : b; }
static inline double most(double a, double b) { return a > b ? a : b; }
static inline double clip(double x, double lo, double hi) { return least(most(x, lo), hi); }

static Fluid fluid_state(double pressure, const double *p)
{
    double p0 = P(oil_reference_pressure), n = P(oil_polytropic_exponent);
    double phi = P(oil_air_fraction), b = P(oil_liquid_bulk_modulus);
    double pg = most(pressure, RAREFIED * p0), below = pg - pressure, k = (n - 1.0) / n, power, growth;
    if (k > 0.01) {
        power = pow(pg / p0, k);
        growth = (power - 1.0) / k;
    } else {
        double l = log(pg / p0), e = expm1(k * l);
        power = 1.0 + e;
        growth = k > 0.0 ? e / k : l;
    }
    double a = phi * power * p0 / pg, slope = a / (n * pg);
    double m = expm1((p0 - pressure) / b), l = (1.0 - phi) * (1.0 + m);
    double nu = a + slope * below + l;
    double air = phi * p0 * growth - below * (a + 0.5 * slope * below);
    return (Fluid){nu, nu / (slope + l / b), air - (1.0 - phi) * b * m};
}

static inline Passage passage(double flow, Fluid up, Fluid down)
{
    double q = flow / (flow > 0.0 ? up.ratio : down.ratio);
    return (Passage){q, q * (up.enthalpy - down.enthalpy)};
}

static inline double signed_root(double dp, double eps) { return dp / sqrt(sqrt(dp * dp + eps * eps)); }

static inline double rated_root(double dp, double rated)
{
    return signed_root(dp / rated, LAMINAR_SHARE) / signed_root(1.0, LAMINAR_SHARE);
}

static inline double power_near_one(double base, double e)
{
    double d = base - 1.0;
    return (12.0 + d * (6.0 * (2.0 + e) + d * (1.0 + e) * (2.0 + e)))
         / (12.0 + d * (6.0 * (2.0 - e) + d * (1.0 - e) * (2.0 - e)));
}

static Branch law_flow(double dp, double opening, const double *u)
{
    double eps = U(valve_branch_transition_pressure), nozzle = U(valve_branch_nozzle);
    if (opening == 0.0) {
        double full = dp / sqrt(sqrt(dp * dp + eps * eps) * nozzle);
        return (Branch){0.0 * full, full, 1.0, 0.0, 0.0};
    }
    double e = 0.5 * U(valve_branch_flow_exponent) - 1.0, a2 = opening * opening, x0 = STILL_FLOW * STILL_FLOW;
    double smooth = sqrt(dp * dp + eps * eps), s = dp * dp / smooth;
    double outlet = a2 * U(valve_branch_outlet_turbine), B = a2 * U(valve_branch_centre_section), A = nozzle + outlet;
    double x_max = s / A, far = B * pow(a2 * x_max + x0, e), ratio = A / (A + far);
    for (int i = 0; i < 2; i++)
        ratio = A / (A + far * power_near_one(ratio, e));
    double x = x_max * ratio, z = a2 * x + x0, term = B * pow(z, e), per_x = a2 / z;
    double slope = e * per_x * term, bend = (e - 1.0) * per_x;
    double g = x * (A + term) - s, g1 = A + term + x * slope, g2 = slope * (2.0 + bend * x);
    double dx = 2.0 * g * g1 / (g * g2 - 2.0 * g1 * g1);
    double centre = term + slope * dx * (1.0 + 0.5 * bend * dx), total = A + centre;
    double full = dp / sqrt(smooth * total), per_total = 1.0 / total;
    return (Branch){opening * full, full, nozzle * per_total, centre * per_total, outlet * per_total};
}

static inline Branch choked(Branch b, double inlet_pressure, const double *u)
{
    double recovery = U(valve_branch_pressure_recovery), q = most(b.full, 0.0);
    if (recovery == 0.0)
        return b;
    double left = most(inlet_pressure - U(valve_branch_boiling_pressure), U(valve_branch_transition_pressure));
    double ratio = U(valve_branch_nozzle) * q * q / (recovery * recovery * left);
    if (ratio <= 1.0)
        return b;
    double kept = 1.0 / ratio, root = sqrt(kept), outlet = b.outlet * kept;
    double centre = b.centre * pow(kept, 0.5 * U(valve_branch_flow_exponent));
    return (Branch){b.flow * root, b.full * root, 1.0 - centre - outlet, centre, outlet};
}

typedef struct { double open, skew; } Wedge;

static inline Wedge wedge(double distance, double half_width, double ramp)
{
    double entered = clip(0.5 + (half_width + distance) / ramp, 0.0, 1.0);
    double remaining = clip(0.5 + (half_width - distance) / ramp, 0.0, 1.0);
    double following = clip(0.5 + (half_width + distance - 1.0) / ramp, 0.0, 1.0);
    double uneven = (entered - remaining) * (entered * remaining - following) * (1.0 - following);
    return (Wedge){entered * remaining + following * (1.0 - remaining), uneven};
}

static inline double film_thickening(double first, double second, const double *p)
{
    double alpha = P(oil_pressure_viscosity), x = alpha * (first - second);
    if (alpha == 0.0)
        return 1.0;
    double mean = 0.5 * (first + second) - P(oil_reference_pressure);
    return exp(alpha * mean) / (1.0 + x * x / 24.0 * (1.0 + x * x / 80.0));
}

static inline double jet_section(double a, double skew, double s)
{
    return (s == 0.0 || a == 0.0 || a == 1.0 ? a : pow(a, 1.0 - s)) * (a + skew);
}

static inline double branch_cavitates(double inlet_pressure, double outlet_pressure, double opening, Branch b, double limit)
{
    double drop = b.nozzle * (inlet_pressure - outlet_pressure), behind = inlet_pressure - drop;
    double low = least(inlet_pressure, behind) - limit;
    return opening > 0.0 && low < CAVITATION_NUMBER * fabs(drop) ? 1.0 : 0.0;
}

static inline double branch_torque(Branch b, double opening, double skew, double speed, double rho, const double *p)
{
    double q = most(b.full, 0.0), out = most(b.flow, 0.0);
    double r_in = P(valve_inlet_radius), r_out = P(valve_outlet_radius), r = b.flow < 0.0 ? r_in : r_out;
    return rho * (r_in / (P(valve_inlet_area_ratio) * P(valve_nozzle_area))) * q * q
           * jet_section(opening, skew, P(valve_jet_exponent))
         + rho * r_out / P(valve_outlet_effective_area) * out * out - rho * r * r * speed * fabs(b.flow);
}

static inline double relief_opening(double pressure, const double *p)
{
    double cracking = P(relief_valve_cracking_pressure), over = P(relief_valve_override_pressure);
    return most(pressure - cracking, 0.0) / (over > 0.0 ? over : cracking);
}

static inline double relief_flow(double pressure, double tank, double opening, double surplus, const double *p)
{
    double cracking = P(relief_valve_cracking_pressure), over = P(relief_valve_override_pressure);
    if (over > 0.0) {
        double y = P(relief_valve_opening_time) > 0.0 ? opening : relief_opening(pressure, p);
        double design = cracking + over - tank;
        return P(relief_valve_rated_flow) * y * rated_root(pressure - tank, design > 0.0 ? design : cracking);
    }
    return pressure >= cracking ? most(surplus, 0.0) : 0.0;
}

static inline double check_opening(double drop, const double *p)
{
    double cracking = P(valve_check_cracking_pressure), reverse = P(valve_check_reverse_opening);
    double lift = clip((drop - cracking) / (P(valve_check_rated_drop) - cracking), 0.0, 1.0);
    return reverse + (1.0 - reverse) * lift;
}

static inline double lag(double goal, double value, double tau) { return tau > 0.0 ? (goal - value) / tau : 0.0; }

static double vessel_rate(double net, double pressure, Fluid fluid, const double *p)
{
    double p0 = P(load_line_precharge_pressure), k = P(load_line_gas_exponent), v0 = P(load_line_oil_volume);
    double compliance = P(load_line_hose_compliance), vg0 = P(load_line_gas_volume);
    double d = pressure - p0, width = 0.01 * p0 + (p0 > 0.0 ? 0.0 : 1.0), slant = sqrt(d * d + width * width);
    double reach = slant + fabs(d), excess = 0.5 * (d > 0.0 ? reach : width * width / reach);
    double gas = vg0 * pow(1.0 + excess / (p0 > 0.0 ? p0 : 1.0), -1.0 / k);
    double volume = v0 * (1.0 + compliance * (pressure - P(oil_reference_pressure))) + vg0 - gas;
    double yielding = gas * (0.5 + 0.5 * d / slant) / (k * (p0 + excess));
    return fluid.ratio * net / (volume / fluid.modulus + v0 * compliance + yielding);
}

void rates(double t, const double *y, const double *u, const double *p, double *dy)
{
    (void)t;
    double inlet_pressure = Y(inlet), load_pressure = Y(load_line), speed = Y(spool_speed);
    double tank_pressure = U(tank_pressure), shaft_speed = P(pump_shaft_speed);
    double motor_speed = P(spool_motor_speed), rho = U(medium_density);
    Fluid tank = {U(tank_volume_ratio), U(tank_bulk_modulus), U(tank_enthalpy)};
    Fluid line = fluid_state(load_pressure, p), inlet = fluid_state(inlet_pressure, p);

    double ripple = P(pump_ripple_amplitude);
    ripple = ripple == 0.0 ? 1.0 : 1.0 + ripple * sin(P(pump_ripple_count) * Y(pump_shaft));
    double ideal = P(pump_displacement) * shaft_speed * ripple;
    Passage pump_leak = passage(P(pump_leakage_conductance) * (inlet_pressure - tank_pressure), inlet, tank);

    double turn = U(valve_ports_sections) * Y(spool_angle) / (2.0 * PI), offset = turn - floor(turn + 0.5), distance = fabs(offset);
    double half_duty = 0.5 * P(valve_axial_position);
    double half_barrier = 0.5 * U(valve_ports_barrier_width), ramp = U(valve_ports_nozzle_width);
    double load_drop = inlet_pressure - load_pressure, check_time = P(valve_check_opening_time);
    double check = check_opening(load_drop, p), lift = check_time > 0.0 ? Y(valve_check_opening) : check;
    Wedge wide = wedge(distance, half_duty + half_barrier, ramp), narrow = wedge(distance, half_duty - half_barrier, ramp);
    double load_open = narrow.open * lift, tank_open = 1.0 - wide.open;
    double closing = P(valve_jet_asymmetry) * (offset < 0.0 ? -1.0 : 1.0);
    double load_skew = closing * narrow.skew * lift, tank_skew = -closing * wide.skew;
    Branch load_branch = choked(law_flow(load_drop, load_open, u), inlet_pressure, u);
    Branch tank_branch = choked(law_flow(inlet_pressure - tank_pressure, tank_open, u), inlet_pressure, u);
    Passage to_load = passage(load_branch.flow, inlet, line), to_tank = passage(tank_branch.flow, inlet, tank);
    double thick = film_thickening(load_pressure, tank_pressure, p);
    Passage leak = passage(U(valve_leakage_conductance) / thick * (load_pressure - tank_pressure), line, tank);
    double surplus = ideal - pump_leak.flow - to_load.flow - to_tank.flow;
    Passage relief = passage(
        relief_flow(inlet_pressure, tank_pressure, Y(relief_valve_opening), inlet.ratio * surplus, p), inlet, tank);

    double coupling = P(coupling_coupling);
    double turbine = branch_torque(load_branch, load_open, load_skew, speed, rho, p)
                   + branch_torque(tank_branch, tank_open, tank_skew, speed, rho, p);
    double friction = U(valve_friction_coefficient) * thick * speed;
    double drive = coupling * (motor_speed - speed), pump_friction = P(pump_friction_torque) * fabs(shaft_speed);
    double coefficient = P(load_discharge_coefficient) * P(load_area) * sqrt(2.0 / rho);
    double drop = load_pressure - tank_pressure;
    Passage load = passage(coefficient * signed_root(drop, P(load_transition_pressure)), line, tank);
    double pumped = ideal - pump_leak.flow, back = to_tank.flow + leak.flow;
    double into_tank = back + relief.flow + load.flow - pumped;
    double taken_in = most(pumped, 0.0) + most(-back, 0.0) + most(-relief.flow, 0.0) + most(-load.flow, 0.0);

#define RATE(name) dy[Y_##name]
    RATE(inlet) = inlet.modulus / P(inlet_volume) * (inlet.ratio * (surplus - relief.flow));
    RATE(relief_valve_opening) = lag(relief_opening(inlet_pressure, p), Y(relief_valve_opening), P(relief_valve_opening_time));
    RATE(valve_check_opening) = lag(check, Y(valve_check_opening), check_time);
    RATE(pump_shaft) = shaft_speed;
    RATE(spool_angle) = speed;
    RATE(spool_speed) = (turbine - friction + drive) / U(spool_inertia);
    RATE(load_line) = vessel_rate(to_load.flow - leak.flow - load.flow, load_pressure, line, p);
    RATE(books_supplied_pump_shaft) = ideal * (inlet.enthalpy - tank.enthalpy) + pump_friction;
    RATE(books_supplied_spool_motor) = drive * motor_speed;
    RATE(books_supplied_tank) = -tank.enthalpy * into_tank;
    RATE(books_spent_valve_nozzle) = to_load.loss * load_branch.nozzle + to_tank.loss * tank_branch.nozzle;
    RATE(books_spent_valve_centre_section) = to_load.loss * load_branch.centre + to_tank.loss * tank_branch.centre;
    RATE(books_spent_valve_outlet_turbine) = to_load.loss * load_branch.outlet + to_tank.loss * tank_branch.outlet;
    RATE(books_spent_relief_valve) = relief.loss;
    RATE(books_spent_valve_leakage) = leak.loss;
    RATE(books_spent_pump_leakage) = pump_leak.loss;
    RATE(books_spent_pump_friction) = pump_friction;
    RATE(books_spent_valve_spool_friction) = friction * speed;
    RATE(books_spent_coupling) = drive * (motor_speed - speed);
    RATE(books_spent_valve_to_spool) = -turbine * speed;
    RATE(books_spent_load) = load.loss;
    RATE(books_taken_in) = taken_in;
    RATE(books_given_out) = taken_in + into_tank;
    RATE(books_totals_inlet_pressure) = inlet_pressure;
    RATE(books_totals_load_line_pressure) = load_pressure;
    RATE(books_totals_valve_load_flow) = to_load.flow - leak.flow;
    RATE(books_totals_valve_tank_flow) = back;
    RATE(books_totals_valve_load_flow_actual) = (to_load.flow - leak.flow) * line.ratio;
    RATE(books_totals_valve_tank_flow_actual) = back * tank.ratio;
    RATE(books_totals_valve_inlet_flow_actual) = -(to_load.flow + to_tank.flow) * inlet.ratio;
    RATE(books_totals_tank_pressure) = tank_pressure;
    RATE(books_totals_pump_flow) = pumped;
    RATE(books_totals_pump_flow_actual) = pumped * inlet.ratio;
    RATE(books_totals_pump_leakage_flow) = pump_leak.flow;
    RATE(books_totals_load_flow) = load.flow;
    RATE(books_totals_load_flow_actual) = load.flow * tank.ratio;
    RATE(books_totals_relief_valve_flow) = relief.flow;
    RATE(books_totals_relief_valve_flow_actual) = relief.flow * tank.ratio;
    RATE(books_totals_valve_leakage) = leak.flow;
    RATE(books_totals_valve_load_opening) = load_open;
    RATE(books_totals_valve_cavitating) = most(
        branch_cavitates(inlet_pressure, load_pressure, load_open, load_branch, P(valve_cavitation_pressure)),
        branch_cavitates(inlet_pressure, tank_pressure, tank_open, tank_branch, P(valve_cavitation_pressure)));
}

/* What depends on oil temperature and tank pressure alone, worked out at every sample. */
void conditions(const double *p, double *u)
{
    double T = P(temperature), warm = 313.15, hot = 373.15, *out = u;
    double rho = P(oil_density) / (1.0 + P(oil_thermal_expansion) * (T - warm));
    double y40 = log(1e6 * P(oil_viscosity_40) + 0.7), y100 = log(1e6 * P(oil_viscosity_100) + 0.7);
    double mu = rho * 1e-6 * (exp(y40 * pow(y100 / y40, log(T / warm) / log(hot / warm))) - 0.7);
    double R = P(valve_spool_radius), N = P(valve_sections), L = P(valve_helix_length);
    double pitch = 2.0 * PI * R / N, slope = 2.0 * L / pitch, c = P(valve_radial_clearance);
    double width = sqrt(2.0 * P(valve_nozzle_area) / (N * slope)), lap = P(valve_lap_ratio);
    double sin2 = slope * slope / (1.0 + slope * slope), eccentricity = P(valve_eccentricity);
    double barriers = 2.0 * N * L / (lap * width * sin2);
    double lands = 2.0 * (2.0 * PI * R / P(valve_land_length)), off_centre = 1.0 + 1.5 * eccentricity * eccentricity;
    double nozzle = P(valve_nozzle_discharge_coefficient) * P(valve_nozzle_area);
    double outlet = P(valve_outlet_discharge_coefficient) * P(valve_outlet_area);
    Fluid tank = fluid_state(P(tank_pressure), p);
    out[U_medium_density] = rho;
    out[U_medium_viscosity] = mu;
    out[U_valve_leakage_conductance] = c * c * c / (12.0 * mu) * (barriers + lands) * off_centre;
    out[U_valve_friction_coefficient] = P(valve_friction_area) * mu * R * R / c / sqrt(1.0 - eccentricity * eccentricity);
    out[U_spool_inertia] = 0.5 * P(valve_spool_mass) * R * R;
    out[U_tank_pressure] = P(tank_pressure);
    out[U_tank_volume_ratio] = tank.ratio;
    out[U_tank_bulk_modulus] = tank.modulus;
    out[U_tank_enthalpy] = tank.enthalpy;
    out[U_valve_branch_nozzle] = 0.5 * rho / (nozzle * nozzle);
    out[U_valve_branch_centre_section] = 1.0 / (P(valve_centre_coefficient) * pow(2.0 * R, P(valve_centre_diameter_exponent)));
    out[U_valve_branch_outlet_turbine] = 0.5 * rho / (outlet * outlet) + P(valve_rail_coefficient);
    out[U_valve_branch_flow_exponent] = P(valve_centre_flow_exponent);
    out[U_valve_branch_transition_pressure] = P(valve_transition_pressure);
    out[U_valve_branch_pressure_recovery] = P(valve_pressure_recovery);
    out[U_valve_branch_boiling_pressure] = 0.96 * P(oil_vapour_pressure);
    out[U_valve_ports_sections] = N;
    out[U_valve_ports_helix_length] = L;
    out[U_valve_ports_nozzle_width] = width / pitch;
    out[U_valve_ports_barrier_width] = lap * (width / pitch);
}

static inline double mark(const double *y, const double *p)
{
    return P(valve_sections) * Y(spool_angle) / (2.0 * PI);
}

static const double A[7][6] = TSIT5_A, C[7] = TSIT5_C, E[7] = TSIT5_E;

static void explicit_step(double t, double step, double t_right, const double *y, const double *u, const double *p,
                          double k[7][STATES], double *trial, double *error)
{
#define STAGE(i, count, when, sum)                                  \
    for (int m = 0; m < count; m++) trial[m] = y[m] + step * (sum); \
    rates(when, trial, u, p, k[i]);
    STAGE(1, ACTIVE, t + C[1] * step, A[1][0] * k[0][m])
    STAGE(2, ACTIVE, t + C[2] * step, A[2][0] * k[0][m] + A[2][1] * k[1][m])
    STAGE(3, ACTIVE, t + C[3] * step, A[3][0] * k[0][m] + A[3][1] * k[1][m] + A[3][2] * k[2][m])
    STAGE(4, ACTIVE, t + C[4] * step,
          A[4][0] * k[0][m] + A[4][1] * k[1][m] + A[4][2] * k[2][m] + A[4][3] * k[3][m])
    STAGE(5, ACTIVE, t_right,
          A[5][0] * k[0][m] + A[5][1] * k[1][m] + A[5][2] * k[2][m] + A[5][3] * k[3][m] + A[5][4] * k[4][m])
    STAGE(6, STATES, t_right,
          A[6][0] * k[0][m] + A[6][1] * k[1][m] + A[6][2] * k[2][m] + A[6][3] * k[3][m] + A[6][4] * k[4][m]
              + A[6][5] * k[5][m])
    for (int m = 0; m < ACTIVE; m++)
        error[m] = step * (E[0] * k[0][m] + E[1] * k[1][m] + E[2] * k[2][m] + E[3] * k[3][m] + E[4] * k[4][m]
                           + E[5] * k[5][m] + E[6] * k[6][m]);
}

static void between(double s, double step, const double *y, const double *trial, double k[7][STATES], double *middle)
{
    double a = (1.0 + 2.0 * s) * (1.0 - s) * (1.0 - s), b = s * s * (3.0 - 2.0 * s);
    double c = step * s * (1.0 - s) * (1.0 - s), d = -step * s * s * (1.0 - s);
    for (int m = 0; m < STATES; m++) middle[m] = y[m] * a + trial[m] * b + c * k[0][m] + d * k[6][m];
}

/* Carries y to t_end; 0 when it got there. Of the marks it keeps the first rows and the last, as a batch does. */
int run(double *y, double *u, const double *p, const double *atol, const double *rtol, double first_step, double period,
        double t_end, long rows, double *mark_times, double *mark_states, double *low, double *high, long *counts)
{
    double k[7][STATES], trial[STATES], error[ACTIVE], middle[STATES], t = 0.0, h = first_step;
    double samples = 0.0, t_sample = least(period, t_end), g0 = mark(y, p);
    long stored = 0, steps = 0, rejected = 0;
    int refused = 0;
    rates(t, y, u, p, k[0]);
    while (t < t_end) {
        int last = t + h * (1.0 + 1e-9) >= t_sample, finite = 1;
        double step = last ? t_sample - t : h, t_right = last ? nextafter(t_sample, -INFINITY) : t + step, size = 0.0;
        explicit_step(t, step, t_right, y, u, p, k, trial, error);
        steps++;
        for (int m = 0; m < ACTIVE; m++) {
            double e = fabs(error[m]) / (atol[m] + rtol[m] * most(fabs(y[m]), fabs(trial[m])));
            finite = finite && e < 1e300;
            size += e * e;
        }
        size = sqrt(size / ACTIVE);
        if (!finite || size > 1.0) {
            rejected++;
            refused = 1;
            h = step * (finite ? most(0.2, 0.9 * pow(size, -0.2)) : 0.1);
            if (h < 1e-14 * most(t, period)) return 1;
            continue;
        }
        double t_new = last ? t_sample : t + step, g1 = mark(trial, p), change = floor(g1) - floor(g0);
        for (int i = 0; i < (int)fabs(change); i++) {
            double goal = change > 0.0 ? floor(g0) + 1.0 + i : floor(g0) - i, lo = 0.0, hi = 1.0;
            for (int j = 0; j < 50; j++) {
                double s = 0.5 * (lo + hi);
                between(s, step, y, trial, k, middle);
                if ((mark(middle, p) < goal) == (g0 < goal)) lo = s;
                else hi = s;
            }
            long row = stored < rows - 1 ? stored : rows - 1;
            between(hi, step, y, trial, k, mark_states + STATES * row);
            mark_times[row] = t + hi * step;
            stored = row + 1;
        }
        for (int m = 0; m < STATES; m++) {
            low[m] = least(low[m], trial[m]);
            high[m] = most(high[m], trial[m]);
        }
        t = t_new;
        g0 = g1;
        memcpy(y, trial, sizeof trial);
        double grown = step * least(refused ? 1.0 : 5.0, most(0.2, 0.9 * pow(size + 1e-12, -0.2)));
        h = last ? most(h, grown) : grown;
        refused = 0;
        if (last) {
            samples += 1.0;
            t_sample = least((samples + 1.0) * period, t_end);
            conditions(p, u);
            rates(t, y, u, p, k[0]);
        } else
            memcpy(k[0], k[6], sizeof k[0]);
    }
    counts[0] = steps;
    counts[1] = rejected;
    counts[2] = stored;
    return 0;
}

/* As many evaluations as asked over the rows of a table of states. */
double evaluations(const double *states, long rows, long rounds, const double *u, const double *p, double *dy)
{
    double sum = 0.0;
    for (long i = 0; i < rounds; i++)
        for (long row = 0; row < rows; row++) {
            rates(0.1, states + STATES * row, u, p, dy);
            sum += dy[0];
        }
    return sum;
}
