"""Every number of the diagnosis that somebody chose, with its reason; what is learned stands in ``weights.json``.

A number belongs here unless it is mathematics (a variance of 1/12, a quantile of the normal), a guard against division by
zero, an index, or stands in a compiled function, whose cache follows its own file only. A test counts what is here and what
is left in the modules, section by section: neither may grow unnoticed.
"""

from __future__ import annotations

import numpy as np
from scipy.special import ndtri

from sstl_cli.physics.scenario import Trajectory

# === said: a finding or none, a name or none

# shares of an effect's response by which its law may be off (model discrepancy, Kennedy and O'Hagan 2001)
SHARES = (0.0, 0.01, 0.03, 0.1, 0.3)
# laws that are off by a share leave that share squared of what they explain: differences of evidence count less the larger the
# gap; the learned weights choose among no share, the middle one and the next
MISFITS = (SHARES[0], *SHARES[2:-1])
# share of its response by which a law is usually off
USUAL_SHARE = MISFITS[1]
# who explains less than this of the squared error beyond the noise is no cause of the gap
HALF = 0.5
# a gap of less than this share of the noise is nobody's cause, and teaches nothing
LEAST_GAP = 0.1
# evidence that a further effect has to add (odds of 150 to 1, as for a hundred and more combinations to choose from)
JOINS_NATS = 5.0
# 49 to 1: one wrong name in fifty
DECIDES_NATS = float(np.log(49.0))
# evidence beyond this is beyond doubt: more of it makes nobody surer that something is there
DOUBT_NATS = 25.0
# squared distance at which a simple hypothesis is told from another at 49:1 in so large a share of cases: their log ratio is
# normal, with half of it as mean and all of it as variance
TOLD = 0.95
DECIDABLE = float(np.ceil((ndtri(TOLD) + np.sqrt(ndtri(TOLD) ** 2 + 2.0 * DECIDES_NATS)) ** 2))
# percent: no library is large enough to promise more
MOST_SURE = 99.0
# fewer events than these are chance: spoilt samples, equal ones in a row, readings of a cell
FEW = 5
# a converter's step up to this share of the noise is no fault: the noise smooths it over
FINE_STEP = 0.5
# what carries less of the squared error beyond the noise is no cause of it
LEAST_SHARE = 0.05
# a region is worse if its error grew by as much as is a gap, and its square by this share of the whole
WORSE, WORSE_OF_ALL = (1.0 + LEAST_GAP) ** 2, 0.02
# correlation and relative slope by which an input tension follows its reference, not something else
TRACKS, SAME_SLOPE = 0.9, 0.2
# runs driven by motion: the output swings this much more than the input can make it ...
SWING = 2.0
# ... and the direction of the motion explains this share of its variance, over so many reversals (fewer are one stroke)
EXPLAINED, LEAST_REVERSALS = 0.7, 3
# a reversal is over when the motion has come this share of its span (presliding and seals let go before); the next one begins
# this share of that before the turning point
BREAKAWAY_SHARE = 0.1
BEFORE_TURN = 2.0 * BREAKAWAY_SHARE

# of a plan: a size is stated as told from its nearest rival if it brings this share of the distance that decides, which a search
# of few rounds need not meet
SETTLED = 0.75

# === read: what counts as a reading, a fault of the recorder, a run that can be judged

# the line has no dynamics above: what is faster costs time and tells nothing
SIMULATION_HZ, ANALYSIS_HZ = 1000.0, 50.0
# two seconds at the analysis rate: fewer say nothing of a loop
MIN_SAMPLES = int(2.0 * ANALYSIS_HZ)
# the input has to move by so many times its noise, and by so many N
MIN_SPAN_SIGMA, MIN_SPAN_N = 20.0, 0.2
# a slow sensor with fewer readings in a run says as good as nothing
MIN_READINGS = 16
# share of repeated samples above which they are copies, in a signal with more noise than this (N); rounding repeats some, which
# count so many times
COPIED, COPIED_NOISE_N, CHANCE_COPIES = 0.1, 1e-5, 3.0
# so many renewals in a row that change nothing are chance; more are a sensor that stands still
MOST_ALIKE = 3
# so many standard deviations away a number stops to be believed: a record of any length could buy the rest with what its model
# misses
AT_MOST = 3.0
# an input goes on over a gap as it came if it is off by less than this share of the way, and that many standard deviations
AS_BEFORE = 0.25
# steps of time that differ by less are the same: clocks are written with few digits
EVEN = 0.01
# a clock is near a steady one where its jitter is below this share of a step (any clock is below 0.29) and so many of its
# readings have a step of their own; the first readings that show the step
STEADY, PLACED, FIRST_PLACED = 0.2, 0.95, 64
# groups of as many readings, by how fast the tension moves, that tell a clock's jitter from noise
RATE_GROUPS = 8
# a spike is so many standard deviations off its neighbours, beside what a steep ramp moves in seven samples
SPIKE_SIGMA, SPIKE_TRAVEL = 8.0, 1.5
# longer ones are no spikes: something moved
SPIKE_RUN = 2
# ... but those that a filter lets decay: at most so long, beside so many on the line on either side
LONGEST_PULSE, BESIDE_PULSE = 16, 6
# chance makes fewer than this many of the runs of equal samples in a record that are called frozen
FROZEN_CHANCE = 1e-3
# readings at a limit: so many at least, more than chance puts on one level, of a signal that comes this close (standard
# deviations) to it; and the share of a run that cannot all be at one
CLIPPED_LEAST, PILED_CHANCE, CLIPPED_SIGMA, CLIPPED_MOST = 3, 1e-6, 6.0, 0.9
# levels that differ by less than this share are one, told apart by arithmetic (a change of unit and back)
SAME_LEVEL = 1e-12
# a limit holds a rounded signal so many times longer than the longest rest
REST = 2.0
# noise below this share of the span is rounding: there is nothing to smooth, and plateaus of the movement are flat
FINEST = 1e-6
# samples by which a corner may be away from where the smoother holds it
ELSEWHERE = 3
# shorter signals have no noise that could be told, and nothing to smooth: less than all places of one corner
SHORTEST_READ, SHORTEST_SMOOTHED = 5, 2 * (ELSEWHERE + 1)
# the ranges of the catalogue are for 5-30 N (EFFECTS: 2 m, 0.45 mm steel tendon): tops outside are brought to this
TARGET_N = 20.0
LOW_N, HIGH_N = 3.0, 60.0
# a controller's stream has to last so long; a line of a propagation has so many samples at least
MIN_STREAM, LEAST_SAMPLES = 2 * MIN_SAMPLES, 20

# a spread from run to run is one of at least as many differences between runs of a bend
FEWEST_CONTRASTS = 2
# windows of a stroke in which an output may rest: so many standard deviations of a difference long, so many at least
WINDOW_TRAVEL, FEWEST_WINDOWS = 6.0, 20

# a neighbour's run must cover this share of a run to have been recorded with it
COVERED = 0.95
# an output leaves its hold where the mean over so many samples spans more than so many usual steps from one to the next; shorter runs
# show neither
SMOOTHED, LEFT_STEPS, SHORTEST_LEFT = 9, 8.0, 20

# === believed: priors, and how far they may be left

# odds (logarithm) of what the catalogue has no name for beside its effects, which assume one friction for both tendons
UNNAMED = -float(np.log(20.0))

# compliance of the load (mm/N) where nobody states it: the paper's spring, and what is found on benches
LOAD_MM_PER_N = (0.125, 0.02, 1.0)
# relative spread of friction from run to run, and how far that of the loop is from the tendon's: where to look first; what has a meaning
RUNS_APART, LOOP_APART = 0.3, 0.2
LOOP_LIMITS = (-0.9, 9.0)
# sizes of a response between 0.1 and 100 standard deviations are alike in every decade
LOG_RANGE = float(np.log(1e3))
# by how much what an output comes in a window of a stroke is off to either side, over the error of that
MIXTURE_WIDTHS = np.sqrt(2.0) ** np.arange(14)
# scatter of a line that jumps, as a share of what it loses on average (a regular sawtooth from nothing has 0.58)
JUMPS = (0.2, 0.5, 1.0)
# friction coefficient times angle of anything that a tendon still moves through (rad)
THETA_LOW, THETA_HIGH = 1e-3, 5.0
# slowest loop (s) and inverse slew rate (s/N) of anything that is called one
SLOWEST_LOOP = (0.5, 0.2)
# a parameter this share of its range from a limit is at it
EDGE = 1e-3
# spreads of the log-normal priors: of the measured white and coloured noise, between two sensors, of the smoother's error
WHITE, MEASURED, ALIKE, SMOOTHER = 0.05, 0.3, 0.35, 0.2
# of coloured noise that no hold shows
UNMEASURED = 1.0
# samples of holds that show the white noise as well
ENOUGH_HELD = round(1.0 / WHITE**2)
# coloured noise, as a share of the white one, that is too small to be seen
UNSEEN = 0.1
# ... that is taken where there are too few holds, and the least that a search starts from
UNKNOWN_COLOUR, LEAST_COLOUR = 0.25, 0.02
# two sensors of a rig are alike within these ratios
ALIKE_TO = 5.0
ALIKE_FROM = 1.0 / ALIKE_TO
# a model on a grid is exact to about this share of the span: less noise than that cannot be told from its own rounding
RESOLVED = 1e-4
# a step with less sliding than this share is a hold
HELD = 1e-3
# windows of holds (s), longest first: the slower the noise, the longer a window must be to show it; so many, so long (samples)
WINDOWS_S = (3.0, 1.0, 0.4)
LEAST_WINDOWS, SHORTEST_WINDOW = 6, SHORTEST_SMOOTHED
# correlation times (s) that sensors have, each twice the one before
CORRELATIONS_S = tuple((0.05 * 2.0 ** np.arange(8.0)).tolist())
# slow noise of a tension sensor is correlated for no longer than this (s): what wanders more slowly moves the tension, or its zero
SENSORS_S = 1.0
# white noise of means over that of third differences, where a sensor is behind a filter
LOUDER = np.geomspace(1.0, 4.0, 13)
# coloured noise that is tried, over the white one of a reading
LEVELS = np.geomspace(0.03, LOUDER[-1], 15)
# orders of difference that show the latent input's steps, and starts of it as shares of those (they are noise for the most part):
# curved throughout, and of straight pieces
STEP_ORDERS = (2, 3)
STEP_SHARES = ((1e-2, 1e-4), (1e-2, 1e-8))
# a known misfit: knots of the map, over the input and over what came before
INPUT_KNOTS, OTHER_KNOTS = 10, 6
# ... they span all but this share at either end; directions, and speeds one way over the other way, with less are none
UNSEEN_SHARE = 0.01
# a reversal counts once the input has come this share of its span
CLEAR = 0.05
# ... over how many knots of each a function over the state is alike (to 1/e), and how much so pulling and releasing
ALIKE_INPUT, ALIKE_OTHER, ALIKE_WAYS = 3.0, 2.0, 0.5
# sizes of the map that are tried, over what there is to map (none at the first)
MAP_SIZES = np.concatenate(([0.0], np.geomspace(0.03, 10.0, 16)))
# degrees of freedom of the scatter's tail where a search for them begins; rounds in which precisions settle; the fewest of which a variance is stated
TAIL, TAIL_ROUNDS, HEAVIEST = 2.0, 3, 3.0
# less than a second makes no map (samples)
LEAST_MAPPED = int(ANALYSIS_HZ)
# how far (natural logarithm) size and correlation time of the scatter may be from their first estimates, and the price beyond
WIDEST, BEYOND_WIDEST = 2.5, 1e3
# independent samples by which a place is drawn to the usual variance of the scatter, and the least share of it
SPREAD, QUIETEST = 10.0, 0.05
# parts of a run whose means are compared, and of the only run for held-out errors; stretches in which a known rig varies: each is
# far longer than what is remembered, and several are in every record
PARTS = 4
STRETCHES = 2 * PARTS
# variances of a way in which a rig varies that are tried, over what one stretch tells of it
VARIANCES = np.geomspace(0.1, 1e6, 71)
# trajectories and configurations share so many folds; what differs from block to block is drawn in blocks of so many seconds
MAX_FOLDS, BLOCK_S = 6, 5.0
# weight of all data beside a training part: who tells less than this of a direction does not foretell it
ALL_COUNT = 0.001

# === sought: starts, steps and budgets of the searches; more of them costs time

# nats: a step that gains less is none
ENOUGH_NATS = 0.1
# iterations of a fit from a start, and of one from a neighbour
MAX_ITERATIONS, REFIT_ITERATIONS = 14, 6
# times that each run is simulated with friction of its own
EACH_ROUNDS = 3
# theta is tried at these times what is said of it: a fit that starts in an endless hold stays there
START_FACTORS = (1.0, 0.6, 1.6, 0.3, 0.1, 0.03)
# how far a pair is stretched beyond where its slack tendon would go slack, over what the input spans: more of it only looks like less friction
PRELOADS = (0.01, 0.1, 0.5, 1.0, 2.0)
# differences that show a slope: in theta, in a parameter (share of its range)
THETA_STEP, PARAMETER_STEP = 1e-4, 2e-3
# Levenberg-Marquardt: first damping, its factor, how often it is raised
DAMPING, DAMPING_FACTOR, DAMPINGS = 1e-3, 8.0, 6
# a step that gains less than this share of what its slopes promise: they are made afresh
KEPT_PROMISE = 0.5
# starts of a fit: shapes on a grid over their range (logarithmic where they span more than this), strengths of the line weak
# and strong (its answer is not linear), a factor (a wrong unit is far from a calibration), a strength beside a shape
SHAPE_GRID, DECADES = (0.15, 0.5, 0.85), 20
STRENGTHS = (0.01, 0.08)
FACTORS = (1.0, 0.3, 3.0)
# a play from the noise to half of what the output spans, in so many widths
WIDTHS = 5
# iterations of the base before its noise is known, of promising and of other candidates
COARSE_ITERATIONS, SHORT_ITERATIONS = 5, 2
BASE_ITERATIONS = 2 * SHORT_ITERATIONS
# with less than this share of the best gain a model is not followed to its optimum: it has lost
PROMISING = 0.3
# how many models are led from (and joined into the richest), refitted beside a leader (and of one effect), and of pairs
LEADERS, PARTNERS, PAIRS = 4, 3, 20
# how many effects stand in for a part of the leading pair
SWAPS = 4
# nats: what adds less is no partner; what is closer to the best is followed to its optimum in any case
ADDS, ALIVE_NATS = 3.0, 40.0
# pull to zero of the flexible model that noise is read beside, as a share of its information
RICH_RIDGE = 1e-4
# shares of the time that screening, coarse fits and combinations take, for the progress that is shown
SCREENED, FITTED = 0.2, 0.3
COMBINED = SCREENED
# so many effects stand together at most: each more costs as much as all combinations before
MOST_EFFECTS = 3
# what the models leave is looked at for so many of the best of each size; the others have lost by what they gain
EXAMINED = 6
# rounds in which the shares of a mixture settle
MIXTURE_ROUNDS = 200
# of the latent input: rounds, factors on a scale that are tried in a round (far ones while it is not yet near), nats that end it
LATENT_ROUNDS = 12
NEAR = (1.0, 0.5, 2.0)
FAR = 10.0
WIDE = (*NEAR, 1.0 / FAR, FAR)
WIDE_ROUNDS = 4
LATENT_ENOUGH_NATS = 0.5
# samples over which a drive may round the corners of its input, and so many times further what it does counts
ROUNDINGS, REACH = tuple(2.0**k for k in range(4)), 4.0
# least start of a scale, in the variance of a reading and the share taken of the typical step
LEAST_SCALE = 1e-6
# of the noise, in spreads of the prior: the difference that shows a slope, a slope (nats) that is none, tries, curvature
DIFFERENCE, FLAT, TRIES, CURVATURE_STEP = 0.03, 0.5, 120, 0.1
# samples that hold six numbers; rounds of leaving disturbed holds out
ENOUGH, HOLD_ROUNDS = 4000, 5
# of the slow noise of an input: steps (s) in which its readings are asked, for how long it may last (s), tries beside the best level,
# how near (natural logarithm) is near enough
HEARD_S, HEARD_TIMES_S, HEARD_TRIES, HEARD_NEAR = 0.5 / ANALYSIS_HZ, CORRELATIONS_S[1:-1:2], 5, 0.1
# lag (s) and inverse slew rate (s/N) next to none, by how many halvings of the slowest a lag is looked for from them, and by how
# many steps a slew rate from the fastest that is asked for: what does nothing yet has no slope, and just below it there is a cliff
NO_LOOP, LOOP_HALVINGS, LOOP_SLEWS = (1e-4, 1e-6), 7, 25
LAG_SCALES = (0.05, 0.01)
# effects of the position: starts (share of the range), difference, evaluations
POSITION_STARTS, POSITION_STEP, POSITION_TRIES = (0.02, 0.1, 0.5), 0.5 * PARAMETER_STEP, 20
# rounds in which a free scale of the output settles
SCALE_ROUNDS = 3
# of the scatter: first step (natural logarithm of size, time, path and tail), tolerances
SCATTER_STEP, SCATTER_NEAR, SCATTER_FLAT = 0.7, 0.02, 0.05
# draws of a bootstrap: its 2.5 % are the 25th of them
DRAWS = 1000
# grid of the loop's lag: longest (s), points, refinements
LAG_LONGEST_S, LAG_POINTS, LAG_ROUNDS = 2.0, 21, 3
# of two runs the other one alone would decide: neither is odd; and runs that are left out in a diagnosis of their own, each of
# which costs as much as the whole
FEWEST_RUNS, CONFIRMED_RUNS = 3, 1

# of a plan: the nearest rivals in the linear picture that are refitted, beside look-alikes; rounds in which the size settles from
# which an effect is told from them, how near (natural logarithm of the distance) is near enough, and the distance that is taken
# for the next size where there is next to none
NEAR_RIVALS, SIZE_ROUNDS, SIZE_NEAR, LEAST_D2 = 3, 6, 0.2, 1e-3

# === shown: bands of tables and tests, and what is listed

# edges of bands (s, Hz) that are tested
SINCE_S = np.array([0.1, 0.3, 1.0, 3.0])
BANDS_HZ = np.array([0.1, 0.5, 2.0, 8.0])
# beyond it the number of standard deviations says nothing more
MOST_SIGMA = 100.0
# what is left above the noise floor of less than this share of the error is nothing that could be explained
REDUCIBLE = 1e-3
# edges of bands (s, Hz) of the table where the error lies
TABLE_SINCE_S = (0.0, 0.2, 0.5, 1.0, 2.0, 5.0, np.inf)
TABLE_HZ = (0.0, 0.05, 0.2, 1.0, 5.0, np.inf)
# an input slower than a hold's share of its fast steps (percentile) rests; an output that moves less (N) is held
FAST_PCT = 95
STILL_N = 1e-6
# effects, places and sizes that a sentence lists, candidates of the table of cosines
LISTED, PLACES, ISOLATED = 4, 3, 12
# tests of what is left that are told where the cause is not known; rivals whose distance from the likeliest is worked out, and as
# many of the most evident
TESTS, RIVALS = 4, 5

# === moved: movements that are proposed, and the task of the controller

# one movement for each thing that a line can show: speed (a loop in so many seconds, and ten times that), holds, small loops,
# frequency, all of them (a minute each, or two)
FAST_S, MINUTE_S = 8.0, 60.0
SLOW_S = 10.0 * FAST_S
MENU = (
    Trajectory(kind="trapezoid", label="fast trapezoid", duration_s=FAST_S, drive="tension"),
    Trajectory(kind="trapezoid", label="slow trapezoid", duration_s=SLOW_S, drive="tension"),
    Trajectory(kind="ramp_hold", label="ramps with holds", duration_s=MINUTE_S, hold_s=0.5 * FAST_S),
    Trajectory(kind="minor_loops", label="minor loops", duration_s=0.5 * SLOW_S),
    Trajectory(kind="chirp", label="chirp", duration_s=MINUTE_S),
    Trajectory(kind="random", label="random", duration_s=2.0 * MINUTE_S),
)
# a plan is judged at no more than this: what is faster tells no more of a line, and lasts longer
FASTEST_HZ = 0.5 * SIMULATION_HZ
# the recorded rate of change that a rig is taken to be able to repeat: the largest, but for the noisiest samples
REPEATABLE = 0.995
# a movement that has to be slowed down to last longer than this is none (s); so many tries, each a little slower than asked for
LONGEST_S = 1200.0
SLOWINGS, SLOWER = 4, 0.98
# digits of tensions (N), angles (rad) and rates (Hz) in a plan
TENSION_DIGITS, ANGLE_DIGITS, RATE_DIGITS = 3, 4, 6
# sampling and stroke of the controller's task; its period is that of the sinusoid to be tracked, so that friction at speed is
# the task's; how long a random reference lasts (s)
DT_S, STROKE_N, CYCLE_S = 0.01, (1.0, 35.0), 100.0
RANDOM_S = 2.0 * CYCLE_S
# 2.5 % of the stroke at either end is left out
COS_END = 0.95
# of the steepest slopes (but for outliers), what counts as sliding; a line below that slope, or with fewer samples, is none
SLIDING, STEEP = 0.85, 0.9
LEAST_SLOPE = 0.02
# a misfit (N) of one play that is not worth removing by plays of several widths
LEAST_MISFIT_N = 1e-3
# how often a controller is fitted to what its model makes of the task
ROUNDS = 2
