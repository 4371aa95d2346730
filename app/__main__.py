"""The console command `weft`, also `python -m app`."""

import sys


def main(arguments: list[str] | None = None) -> int:
    """Run `weft` with `arguments` (those of the process by default) and return its exit status, 130 if interrupted."""
    try:
        from app import cli  # loads for a while, in which an interrupt is heard as well

        return cli.main(arguments)
    except KeyboardInterrupt:
        sys.stderr.write("weft: interrupted\n")
        # Python ends by the signal after an interrupt within code run from text, if this does not come after it.
        exec("")
        return 130


if __name__ == "__main__":
    sys.exit(main())
