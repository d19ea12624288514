/* Feedforward compensation of tendon-sheath hysteresis (Algorithm 1), one configuration.
 * Written by sstl export; configuration @CONFIG@.
 *
 * Call sstl_controller_init() once and sstl_controller_step() every @PERIOD@ s with the reference of
 * the output tension and the measured input tension, both in N. No allocation, no global state.
 * When an input is not a number or out of range the step answers SSTL_SAFE: it holds the last command,
 * then ramps it down to zero; `fault` in the state tells why (SSTL_FAULT_ bits).
@PRECISION@ */
#ifndef SSTL_CONTROLLER_H
#define SSTL_CONTROLLER_H

#ifdef __cplusplus
extern "C" {
#endif

typedef @REAL@ sstl_real;

enum { SSTL_PLAYS = @PLAYS@ };
enum sstl_phase { SSTL_PB = 0, SSTL_PP = 1, SSTL_RB = 2, SSTL_RP = 3, SSTL_SAFE = 4 };
enum sstl_fault {
    SSTL_FAULT_REF_NOT_FINITE = 1,
    SSTL_FAULT_REF_OUTSIDE = 2,
    SSTL_FAULT_IN_NOT_FINITE = 4,
    SSTL_FAULT_IN_OUTSIDE = 8
};

typedef struct {
    int awake, started, direction, backlash, returning, fresh;
    unsigned fault;
    long lost;
    sstl_real extreme, out_rev, threshold, command, wish, model, aim;
    sstl_real play[SSTL_PLAYS];
} sstl_controller;

void sstl_controller_init(sstl_controller *c);

/* Returns the commanded input tension in N; *phase takes one of enum sstl_phase. */
sstl_real sstl_controller_step(sstl_controller *c, sstl_real t_ref, sstl_real t_in, int *phase);

#ifdef __cplusplus
}
#endif

#endif
