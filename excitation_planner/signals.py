"""Kinds of motion a plan may be, and what bounds every plan."""

RANDOM_PULSES = 'random_pulses'
BAND_LIMITED_NOISE = 'band_limited_noise'
# Band-limited noise on slow sweeps that keep the joints sliding.
SLIDING_NOISE = 'sliding_noise'
# One slow move to where an excitation starts.
APPROACH = 'approach'
SIGNALS = (RANDOM_PULSES, BAND_LIMITED_NOISE, SLIDING_NOISE, APPROACH)
# Asked for: sliding noise where the allowed range is wide enough, else band-limited noise.
AUTOMATIC = 'automatic'
# Sent as speed references.
NOISES = (BAND_LIMITED_NOISE, SLIDING_NOISE, AUTOMATIC)
# Of point-to-point moves, which a program of the controller can make.
MOVES = (RANDOM_PULSES, APPROACH)
# Servo, filter and 4 ms cycle of the controller leave nothing above this.
HIGHEST_PATH_HZ = 60.0
# Ten of the identifier's windows of a minute at one pose, and all the while a person holds to run;
# who wants more makes several plans.  A sample for every 4 ms cycle of the controller: a denser
# plan would not be sent denser.  Checking such a plan takes 13 s of one core, 0.09 ms a sample
# whatever the length (measured from 7,500 to 150,001 samples, six axes).
LONGEST_S = 600.0
MOST_SAMPLES = 150_001
