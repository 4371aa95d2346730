"""The timing tables of `weft bench`, one file per engine."""
