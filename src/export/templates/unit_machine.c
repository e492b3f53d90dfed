/* Written by muspin: shaft in its modes, magnets with force law and limits of current, voltage and force, backup bearings.
 * Exponential integrator of second order, as `muspin simulate`; the pure delay of the commands is part of the unit. */
#include <math.h>
#include "machine_data.h"
#include "unit.h"

#define COMMAND 1
#define LOAD (COMMAND + AXES)
#define SENSOR (LOAD + LOADS)
#define DISPLACEMENT (SENSOR + AXES)
#define CURRENT (DISPLACEMENT + LOADS)
#define VOLTAGE (CURRENT + AXES)
#define FORCE (VOLTAGE + AXES)
#define CONTACT (FORCE + AXES)

struct unit {
    struct unit_base base;
    double state[STATES];
    double waiting[LATE + 1][AXES]; /* commands of the last substeps */
};

const unsigned long unit_bytes = sizeof(unit);
struct unit_base *unit_of(unit *u) { return &u->base; }

static double held(double value, double low, double high)
{
    return value < low ? low : value > high ? high : value;
}

static double row(const double *coefficients, const double *x, int count)
{
    double sum = 0.0;
    int k;
    for (k = 0; k < count; ++k) {
        sum += coefficients[k] * x[k];
    }
    return sum;
}

static double pull(const struct magnet *m, double current, double x)
{
    const double xi = held(m->kappa_per_m * x, -LARGEST_XI, LARGEST_XI), eta = current / m->bias_a;
    const double most = m->max_a / m->bias_a, scale = 0.25 * m->ki_n_per_a * m->bias_a, largest = m->max_n / scale;
    const double plus = held(1.0 + eta, 0.0, most) / (1.0 - xi), minus = held(1.0 - eta, 0.0, most) / (1.0 + xi);
    return scale * (fmin(plus * plus, largest) - fmin(minus * minus, largest));
}

static void touch(const double *x, const double *v, double *f)
{
    const double radius = hypot(x[0], x[1]), depth = radius - CLEARANCE_M;
    double nx, ny, normal, sliding, tangential;
    f[0] = f[1] = 0.0;
    if (depth <= 0.0) {
        return;
    }
    nx = x[0] / radius;
    ny = x[1] / radius;
    normal = fmax(CONTACT_N_PER_M * depth + CONTACT_N_S_PER_M * (v[0] * nx + v[1] * ny), 0.0);
    sliding = -v[0] * ny + v[1] * nx + SPEED_RAD_S * CONTACT_RADIUS_M;
    tangential = -FRICTION * normal * tanh(sliding / FRICTION_SPEED_M_S);
    f[0] = -normal * nx - tangential * ny;
    f[1] = -normal * ny + tangential * nx;
}

/* Magnetic and contact forces at a state. */
static void forces(const unit *u, const double *state, double *magnetic, double *contact)
{
    int b, axis;
    for (b = 0; b < 2; ++b) {
        double x[2], v[2], own[2], by_current[2];
        for (axis = 0; axis < 2; ++axis) {
            const int at = 2 + 2 * b + axis;
            x[axis] = row(outputs[AXES + at], state, STATES);
            v[axis] = row(velocities[at], state, STATES);
            own[axis] = pull(&magnets[2 * b + axis], u->base.value[CURRENT + 2 * b + axis], x[axis]);
            by_current[axis] = own[axis] - pull(&magnets[2 * b + axis], 0.0, x[axis]);
        }
        for (axis = 0; axis < 2; ++axis) {
            magnetic[2 * b + axis] = own[axis] + coupling_ratios[b] * by_current[1 - axis];
        }
        touch(x, v, contact + 2 * b);
    }
}

static void total(const unit *u, const double *state, double *f)
{
    double magnetic[AXES], contact[AXES];
    int k;
    forces(u, state, magnetic, contact);
    for (k = 0; k < LOADS; ++k) {
        f[k] = u->base.value[LOAD + k] + (k < 2 ? 0.0 : magnetic[k - 2] + contact[k - 2]);
    }
}

static void observe(unit *u)
{
    double f[LOADS];
    double *v = u->base.value;
    int k;
    total(u, u->state, f);
    for (k = 0; k < AXES + LOADS; ++k) {
        v[SENSOR + k] = row(outputs[k], u->state, STATES) + row(direct[k], f, LOADS);
    }
    for (k = 0; k < AXES && QUANTUM_M > 0.0; ++k) {
        v[SENSOR + k] = round(v[SENSOR + k] / QUANTUM_M) * QUANTUM_M;
    }
    forces(u, u->state, v + FORCE, v + CONTACT);
}

static void substep(unit *u)
{
    double start[LOADS], end[LOADS], predicted[STATES];
    double *v = u->base.value;
    const double *command = u->waiting[(u->base.done + 1) % (LATE + 1)];
    int k, j;
    for (k = 0; k < AXES; ++k) {
        u->waiting[u->base.done % (LATE + 1)][k] = v[COMMAND + k];
    }
    total(u, u->state, start);
    for (k = 0; k < AXES; ++k) {
        const struct magnet *m = &magnets[k];
        const double reach = fmax(m->max_a - m->bias_a, m->bias_a), most = m->slew_a_per_s * STEP_S;
        const double wanted = (held(command[k], -reach, reach) - v[CURRENT + k]) * (1.0 - exp(-m->corner_rad_s * STEP_S));
        const double change = held(wanted, -most, most), voltage = m->inductance_h * change / STEP_S;
        v[CURRENT + k] += change;
        if (fabs(voltage) > fabs(v[VOLTAGE + k])) {
            v[VOLTAGE + k] = voltage;
        }
    }
    for (k = 0; k < STATES; ++k) {
        predicted[k] = row(phi[k], u->state, STATES) + row(gamma_0[k], start, LOADS);
    }
    total(u, predicted, end);
    for (j = 0; j < LOADS; ++j) {
        end[j] -= start[j];
    }
    for (k = 0; k < STATES; ++k) {
        u->state[k] = predicted[k] + row(gamma_1[k], end, LOADS);
    }
    ++u->base.done;
}

void unit_start(unit *u)
{
    int k, j;
    for (k = 0; k < UNIT_VARIABLES; ++k) {
        u->base.value[k] = 0.0;
    }
    u->base.done = 0;
    for (k = 0; k < STATES; ++k) {
        u->state[k] = 0.0;
    }
    for (k = 0; k <= LATE; ++k) {
        for (j = 0; j < AXES; ++j) {
            u->waiting[k][j] = 0.0;
        }
    }
    observe(u);
}

void unit_advance(unit *u, double end_s)
{
    int k;
    for (k = 0; k < AXES; ++k) {
        u->base.value[VOLTAGE + k] = 0.0;
    }
    while (((double)u->base.done + 0.5) * STEP_S < end_s) {
        substep(u);
    }
    observe(u);
    u->base.value[0] = end_s;
}
