"""The console command `weft`, also `python -m app`."""

import sys


def main(arguments: list[str] | None = None) -> int:
    """Run `weft` with `arguments` (those of the process by default) and return its exit status, 130 if interrupted."""
    try:
        from app.window.loading import loading

        with loading():
            from app import cli

        return cli.main(arguments)
    except KeyboardInterrupt:
        sys.stderr.write("weft: interrupted\n")
        # Having seen an interrupt leave code that was run from text, as the start is, Python would end by the signal at
        # exit, whatever the status. Text that runs to its end takes that back.
        exec("")
        return 130


if __name__ == "__main__":
    sys.exit(main())
