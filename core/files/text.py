"""Text that came from outside and may be none, such as names of files and entries of metadata."""


def legible(text: str) -> str:
    """Return a text with bytes in it that are not UTF-8 as the text that it is in Windows' Latin; others as they are.

    Python reads such bytes as lone surrogates, U+DC80 to U+DCFF, which no window, no picture and no terminal takes.
    """
    try:
        text.encode("utf-8")
    except UnicodeEncodeError:
        try:
            return text.encode("utf-8", "surrogateescape").decode("cp1252", "replace")
        except UnicodeEncodeError:  # surrogates that stand for no byte
            return text.encode("utf-8", "replace").decode("utf-8")
    return text


def begin_sentence(text: str) -> str:
    """Return a text whose first word begins with a capital, unless it is a name that does not, such as a file's."""
    first = text.split(maxsplit=1)[0].rstrip(":,") if text.strip() else ""
    return f"{text[0].upper()}{text[1:]}" if first.isalpha() else text
