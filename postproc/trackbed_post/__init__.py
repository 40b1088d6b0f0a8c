"""Results of trackbed: arrays with units, figures, films, reports, signals.

    import trackbed_post
    run = trackbed_post.results("results/quickstart/wedge")
    run.sleeper["displacement"].values                       # [time, sleeper], m

On the command line: python3 -m trackbed_post COMMAND; `--help` lists the commands.
"""
from trackbed_post.read import (Quantity, Results, Unreadable, checkpoint, datasets, fields, origin,
                                results, series)

__all__ = ["Quantity", "Results", "Unreadable", "checkpoint", "datasets", "fields", "origin",
           "results", "series"]
