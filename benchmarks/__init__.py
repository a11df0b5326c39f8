"""Our figures beside the peers', on the same arrays, in the same run."""

import os

# Two BLAS threads make the small LAPACK calls of modal analysis ten times slower than one.
for variable in ('OPENBLAS_NUM_THREADS', 'OMP_NUM_THREADS', 'MKL_NUM_THREADS'):
    os.environ[variable] = '1'
