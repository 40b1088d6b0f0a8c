"""Kills a writer of checkpoints at many instants: afterwards the latest one is complete and not
older than the last one that the writer reported. Usage: kill_writer.py WRITER"""

import random
import shutil
import subprocess
import sys
import tempfile
import time

writer = sys.argv[1]
folder = tempfile.mkdtemp(prefix="kill_writer_")
random.seed(3)
kills, with_checkpoint = 12, 0
try:
    for kill in range(kills):
        process = subprocess.Popen([writer, "write", folder], stdout=subprocess.PIPE, text=True)
        first = process.stdout.readline()  # it has started
        time.sleep(random.uniform(0.0, 0.15))
        process.kill()
        lines = ([first] + process.stdout.readlines()) if first else []
        process.wait()
        finished = max([int(line) for line in lines if line.endswith("\n")], default=0)
        found = subprocess.run([writer, "check", folder], capture_output=True, text=True)
        if found.returncode != 0:
            sys.exit(f"kill {kill}: no complete checkpoint: {found.stderr}{found.stdout}")
        # It may have been killed between the last step and its report.
        if int(found.stdout) not in (finished, finished + 1):
            sys.exit(f"kill {kill}: latest is {found.stdout}, the writer had finished {finished}")
        with_checkpoint += finished > 0
    if with_checkpoint < kills // 2:
        sys.exit("the writer hardly ever finished a checkpoint: the test proves nothing")
finally:
    shutil.rmtree(folder)
