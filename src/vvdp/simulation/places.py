"""Layout of the flat arrays that Python and the compiled loop share."""

# What `run` returns.
DONE, PAUSED, MARKS_FULL, NOT_FINITE, STEP_TOO_SMALL, STOP_BEHIND, TOO_MANY_WAITING, RESTLESS, BELOW_ZERO = range(9)
HANDED = 9  # a case that the loop for many at once leaves to the one for one case

# Places in `clock`.
TIME, STEP, BEGUN, STEPS, REJECTED, EVALUATIONS, RECORDS, MARKS, STORED, METHOD = range(10)
REFUSED, MARK_BEFORE, LANDED, JUMPS, JUMP_TIME = range(10, 15)
SWITCHES, SIGNS, FASTEST, ERROR_BEFORE, STEP_BEFORE, AIMED = range(15, 21)
EVENTS, EVENT_TIME, HASTY, CULPRIT, SPANS = range(21, 26)
STIFF_FIRST, SPARED, DOUBT = range(26, 29)
CLOCK = 29

EXPLICIT, STIFF = 0.0, 1.0
AUTOMATIC, ONLY_EXPLICIT, ONLY_STIFF = 0, 1, 2

# The sampled functions have a row each in `plan` and `agenda`: first the conditions, then the programs. Columns of
# `plan`: times are phase + n period; TRIGGER is the place among the events, 0 for a program that goes by the clock;
# its command lies in FIRST to LAST; so do the modes, in the row of the conditions.
PERIOD, PHASE, LATENCY, TRIGGER, FIRST, LAST = range(6)

# Columns of `agenda`: the n of the next sample, how often it was called, the floor of its trigger, whether it has had
# its turn at this instant, and the ring of commands that wait for their time.
NUMBER, CALLS, LEVEL, SERVED, HEAD, WAITING, DUE = range(7)
DEPTH = 16
AGENDA = DUE + DEPTH

# A queue that threads share: the number of the next case, and whether all are to stop where they are.
NEXT, HALT = 0, 1

# Instants nearer to each other than this share of the time are one: two ways of rounding the same multiple.
HAIR = 2e-15
