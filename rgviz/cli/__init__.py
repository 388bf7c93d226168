"""The command line. Imports are made inside the commands so that ``rgviz --help`` answers at once."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from rgcore.errors import RgError, one_line
from rgviz.cli.arguments import parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; the exit code: 0 done, 1 a one-line error, 2 wrong usage, 130 stopped by Ctrl+C."""
    args = parser().parse_args(argv)
    try:
        args.command(args)
        return 0
    except KeyboardInterrupt:
        return _stopped()
    except BrokenPipeError:
        sys.stderr.close()
        return 0
    except (RgError, OSError) as e:
        if args.debug:
            raise
        print(f"rgviz: {one_line(e)}", file=sys.stderr)
        return 1
    except MemoryError as e:
        if args.debug:
            raise
        print(f"rgviz: not enough memory ({one_line(e) or 'none left'}); close other programs", file=sys.stderr)
        return 1
    except Exception as e:
        if _by_ctrl_c(e):
            return _stopped()
        if args.debug:
            raise
        fault = f"{type(e).__name__}: {one_line(e)}"
        print(f"rgviz: a fault in rgviz: {fault}; run it again with --debug and report what it says", file=sys.stderr)
        return 1


def _stopped() -> int:
    print("stopped", file=sys.stderr)
    return 130


def _by_ctrl_c(e: BaseException | None) -> bool:
    """Whether an error only wraps a Ctrl+C: compiled kernels turn one that meets them into a SystemError."""
    while e is not None and not isinstance(e, KeyboardInterrupt):
        e = e.__cause__ or e.__context__
    return e is not None
