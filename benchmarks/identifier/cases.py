"""The cases by name, each run by itself and its cost printed.

`python -m benchmarks.identifier.cases NAME RECORD RESULT` runs one.

One process per case, importing only what the case needs: its peak memory is the case's own.
"""

from functools import partial
import json
from pathlib import Path
import sys
import time

import numpy as np

from benchmarks.identifier import ours, peers
from benchmarks.identifier.record import RATE_HZ

CASES = {
    'ours idle': ours.idle,
    'ours cov 42': partial(ours.ssi_cov, 42),
    'ours cov 6': partial(ours.ssi_cov, 6),
    'ours std of all poles': partial(ours.ssi_cov_std, 'all'),
    'ours std of the modes': partial(ours.ssi_cov_std, 'mode'),
    'ours poles for std': partial(ours.ssi_cov_std, 'none'),
    'ours data 42': partial(ours.ssi_data, 42),
    'ours data 6': partial(ours.ssi_data, 6),
    'ours plscf poles': partial(ours.plscf_poles, 6),
    'ours plscf': partial(ours.method, 'plscf'),
    'ours efdd': partial(ours.method, 'efdd'),
    'ours automatic': partial(ours.method, 'ssi_cov'),
    'pyoma2 cov 42': partial(peers.pyoma2_ssi, 'cov', 42),
    'pyoma2 cov 6': partial(peers.pyoma2_ssi, 'cov', 6),
    'pyoma2 cov_R 42': partial(peers.pyoma2_ssi, 'cov_R', 42),
    'pyoma2 data 42': partial(peers.pyoma2_ssi, 'dat', 42),
    'pyoma2 data 6': partial(peers.pyoma2_ssi, 'dat', 6),
    'pyoma2 std': partial(peers.pyoma2_ssi, 'cov', 6, with_std=True),
    'pyoma2 plscf': partial(peers.pyoma2_plscf, 6),
    'pyoma2 efdd': partial(peers.pyoma2_efdd, False),
    'pyoma2 efdd wide': partial(peers.pyoma2_efdd, True),
    'koma cov 42': peers.koma_ssi,
    'strid cov 42': partial(peers.strid_ssi, 42),
    'strid cov 6': partial(peers.strid_ssi, 6),
}


def main() -> None:
    name, record, result = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3])
    call = CASES[name]()
    rows = np.load(record)
    start = time.process_time()
    found = call(rows, RATE_HZ)
    cpu_s = time.process_time() - start
    # Not ru_maxrss: a child inherits that from the process that started it.
    status = Path('/proc/self/status').read_text(encoding='ascii').split('VmHWM:')[1]
    found.save(result)
    print(json.dumps({'cpu_s': cpu_s, 'peak_mb': float(status.split()[0]) / 1024.0}))


if __name__ == '__main__':
    main()
