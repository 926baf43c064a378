"""Run studies, ``python -m benchmarks [STUDY ...]``, ``same_results`` or ``before_and_after``."""

import argparse
import sys

from benchmarks import STUDIES, before_and_after, same_results
from benchmarks.runner import run_study


def main() -> int:
    comparisons = {
        "same_results": same_results.main,
        "before_and_after": before_and_after.main,
    }
    if sys.argv[1:2] and sys.argv[1] in comparisons:
        return comparisons[sys.argv[1]](sys.argv[2:])
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks",
        description="Speed against error.",
        epilog="same_results --reference PYTHON [...] compares all results with those of another checkout, "
        "before_and_after --reference PYTHON [...] the times.",
    )
    parser.add_argument("studies", nargs="*", metavar="STUDY", help=f"one or more of {', '.join(STUDIES)}")
    parser.add_argument("--short", action="store_true", help="the short form: all studies in two minutes")
    parser.add_argument("--fresh", action="store_true", help="measure again what is already stored")
    arguments = parser.parse_args()
    unknown = sorted(set(arguments.studies) - set(STUDIES))
    if unknown:
        parser.error(f"no study {', '.join(unknown)}; there are {', '.join(STUDIES)}")
    for name in arguments.studies or STUDIES:
        run_study(name, short=arguments.short, fresh=arguments.fresh)
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit("interrupted; run the same command again to go on")
