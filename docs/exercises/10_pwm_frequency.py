"""The frequency of a rotary valve.

The spool of the shipped system `prototype` has 3 helical sections, and each switches once per revolution. It
turns at 1477 rpm. At which frequency does the valve switch?
"""

import sys

from vvdp.api.exercise import Exercise

EXERCISE = Exercise(
    question=__doc__ or "",
    circuit="prototype",
    key="pwm_frequency_Hz",
    hint="Each section switches once per revolution of the spool.",
    mistakes=(
        (
            lambda right: right / 3.0,
            "That is the frequency of the spool: each of its 3 sections switches once per revolution.",
        ),
    ),
)

if __name__ == "__main__":
    sys.exit(EXERCISE.main())
