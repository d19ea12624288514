/* Feedforward compensation of tendon-sheath hysteresis (Algorithm 1); see the header.
 * Build with FMA contraction off (-std=c99 does so, or -ffp-contract=off) to match the Python controller.
 */
#include "@HEADER@"

#include <math.h>

/* parameters of configuration @CONFIG@, method @METHOD@ */
@CONSTANTS@
static const sstl_real SHARES[SSTL_PLAYS] = {@SHARES@};

enum { COMPENSATE = @COMPENSATE@, DOUBLED = @DOUBLED@, FOLLOW = @FOLLOW@, BOUNDED = @BOUNDED@, SOLVE_STEPS = 80 };

static sstl_real least(sstl_real a, sstl_real b) { return b < a ? b : a; }
static sstl_real most(sstl_real a, sstl_real b) { return b > a ? b : a; }

static unsigned fault_of(sstl_real t_ref, sstl_real t_in)
{
    unsigned fault = 0u;
    if (!isfinite(t_ref)) {
        fault |= SSTL_FAULT_REF_NOT_FINITE;
    } else if (t_ref < REF_LOW || t_ref > REF_HIGH) {
        fault |= SSTL_FAULT_REF_OUTSIDE;
    }
    if (!isfinite(t_in)) {
        fault |= SSTL_FAULT_IN_NOT_FINITE;
    } else if (t_in < IN_LOW || t_in > IN_HIGH) {
        fault |= SSTL_FAULT_IN_OUTSIDE;
    }
    return fault;
}

/* hold the last command, then ramp down to zero */
static sstl_real safe(sstl_controller *c)
{
    if (c->lost <= HOLD) {
        c->lost += 1;
    }
    if (c->lost > HOLD) {
        c->command = most(c->command - RAMP, (sstl_real)0.0);
        c->started = 0;
    }
    c->returning = c->awake;
    c->model += LOOP_GAIN * (c->command - c->model);
    return c->command;
}

/* follow the direction of the reference; 1 at a reversal */
static int turned_round(sstl_controller *c, sstl_real t_ref)
{
    int before = c->direction;
    if (!c->started) {
        c->started = 1;
        c->direction = 0;
        c->backlash = 0;
        c->extreme = t_ref;
        c->fresh = 1;
        return 0;
    }
    if (t_ref > c->extreme + DEADBAND) {
        c->direction = 1;
    } else if (t_ref < c->extreme - DEADBAND) {
        c->direction = -1;
    }
    if (c->direction != before) {
        c->extreme = t_ref;
    } else if (before > 0) {
        c->extreme = most(c->extreme, t_ref);
    } else if (before < 0) {
        c->extreme = least(c->extreme, t_ref);
    }
    return before != 0 && c->direction != before;
}

static int algorithm_1(sstl_controller *c, sstl_real t_ref, sstl_real t_in, int turned)
{
    int release = c->direction < 0;
    sstl_real gamma = release ? GAMMA_R : GAMMA_P;
    sstl_real beta = release ? BETA_R : BETA_P;
    sstl_real target = t_ref;
    if (turned) {
        if (!c->backlash) {
            c->out_rev = release ? GAMMA_P * t_in + BETA_P : GAMMA_R * t_in + BETA_R;
            c->backlash = 1;
        }
        c->threshold = (c->out_rev - beta) / gamma;
    }
    if (c->backlash && (release ? t_in <= c->threshold + SLACK : t_in >= c->threshold - SLACK)) {
        c->backlash = 0;
    }
    if (c->backlash && DOUBLED) {
        target = (sstl_real)2.0 * t_ref - c->out_rev;
    }
    c->wish = (target - beta) / gamma;
    if (release) {
        return c->backlash ? SSTL_RB : SSTL_RP;
    }
    return c->backlash ? SSTL_PB : SSTL_PP;
}

static sstl_real pull_line(sstl_real t, sstl_real share)
{
    return t + share * ((GAMMA_P - (sstl_real)1.0) * t + BETA_P);
}

static sstl_real release_line(sstl_real t, sstl_real share)
{
    return t + share * ((GAMMA_R - (sstl_real)1.0) * t + BETA_R);
}

/* the input tension at which the plays give the reference */
static sstl_real solve(const sstl_controller *c, sstl_real t_ref)
{
    sstl_real lower = (sstl_real)0.0, upper = T_MAX;
    sstl_real t = least(most(c->wish, lower), upper);
    int i, j;
    for (i = 0; i < SOLVE_STEPS; i++) {
        sstl_real y = (sstl_real)0.0, slope = (sstl_real)0.0, error, middle;
        for (j = 0; j < SSTL_PLAYS; j++) {
            sstl_real share = SHARES[j];
            sstl_real low = pull_line(t, share), high = release_line(t, share), held = c->play[j];
            if (held <= low) {
                y += low;
                slope += (sstl_real)1.0 + share * (GAMMA_P - (sstl_real)1.0);
            } else if (held >= high) {
                y += high;
                slope += (sstl_real)1.0 + share * (GAMMA_R - (sstl_real)1.0);
            } else {
                y += held;
            }
        }
        error = t_ref - y / (sstl_real)SSTL_PLAYS;
        if (@FABS@(error) <= TOLERANCE || upper - lower <= TOLERANCE) {
            break;
        }
        if (error > (sstl_real)0.0) {
            lower = t;
        } else {
            upper = t;
        }
        middle = (sstl_real)0.5 * (lower + upper);
        t = slope > (sstl_real)0.0 ? t + error * (sstl_real)SSTL_PLAYS / slope : middle;
        if (!(t > lower && t < upper)) {
            t = middle;
        }
    }
    return t;
}

static int follow(sstl_controller *c, sstl_real t_ref, sstl_real t_in)
{
    int release = c->direction < 0, settled = 1, fresh = c->fresh, j;
    sstl_real output = (sstl_real)0.0, band_up, band_down;
    for (j = 0; j < SSTL_PLAYS; j++) {
        sstl_real low = pull_line(t_in, SHARES[j]), high = release_line(t_in, SHARES[j]);
        sstl_real y = fresh ? low : most(low, least(c->play[j], high));
        sstl_real line = release ? high : low;
        c->play[j] = y;
        output += y;
        settled = settled && y >= line && y <= line;
    }
    c->fresh = 0;
    output /= (sstl_real)SSTL_PLAYS;
    band_up = release ? BAND : (sstl_real)0.0;
    band_down = c->direction > 0 ? BAND : (sstl_real)0.0;
    if (fresh || t_ref > output + band_up || t_ref < output - band_down) {
        c->wish = solve(c, t_ref);
    }
    if (release) {
        return settled ? SSTL_RP : SSTL_RB;
    }
    return settled ? SSTL_PP : SSTL_PB;
}

/* loop-lag lead, range, and bounds on the change of the command */
static sstl_real issue(sstl_controller *c)
{
    sstl_real command = c->wish, limit = STEP_MAX;
    int bounded = BOUNDED;
    if (LOOP_GAIN < (sstl_real)1.0 && COMPENSATE) {
        sstl_real behind = c->aim - c->model, lead = behind / LOOP_GAIN;
        if (BOUNDED) {
            sstl_real top = @SQRT@((sstl_real)2.0 * STEP_MAX / LOOP_GAIN * @FABS@(behind));
            lead = least(most(lead, -top), top);
        }
        command = c->model + lead + (c->wish - c->aim) / LOOP_GAIN;
    }
    c->aim = c->wish;
    command = least(most(command, (sstl_real)0.0), T_MAX);
    if (c->returning) {
        if (@FABS@(command - c->command) <= RAMP + SLACK) {
            c->returning = 0;
        } else {
            limit = RAMP;
            bounded = 1;
        }
    }
    if (bounded) {
        command = least(most(command, c->command - limit), c->command + limit);
    }
    c->command = command;
    c->model += LOOP_GAIN * (command - c->model);
    return command;
}

void sstl_controller_init(sstl_controller *c)
{
    int j;
    c->awake = c->started = c->direction = c->backlash = c->returning = 0;
    c->fresh = 1;
    c->fault = 0u;
    c->lost = 0;
    c->extreme = c->out_rev = c->threshold = (sstl_real)0.0;
    c->command = c->wish = c->model = c->aim = (sstl_real)0.0;
    for (j = 0; j < SSTL_PLAYS; j++) {
        c->play[j] = (sstl_real)0.0;
    }
}

sstl_real sstl_controller_step(sstl_controller *c, sstl_real t_ref, sstl_real t_in, int *phase)
{
    int turned;
    c->fault = fault_of(t_ref, t_in);
    if (c->fault != 0u) {
        *phase = SSTL_SAFE;
        return safe(c);
    }
    c->lost = 0;
    if (!c->awake) {
        c->awake = 1;
        c->command = least(most(t_in, (sstl_real)0.0), T_MAX);
        c->wish = c->model = c->aim = c->command;
    }
    c->model += OBSERVER * (t_in - c->model);
    turned = turned_round(c, t_ref);
    *phase = FOLLOW ? follow(c, t_ref, t_in) : algorithm_1(c, t_ref, t_in, turned);
    if (!COMPENSATE) {
        c->wish = t_ref;
    }
    return issue(c);
}
