"""The pages that follow from the code: every equation is computed somewhere, and the pages are those of this code."""

import pytest

from docs.make_pages import EQUATIONS, ROOT, citations, cited_in, equations_page, with_rooms

NUMBERED = [(paper, number) for paper, numbers in EQUATIONS.items() for number in numbers]


@pytest.mark.parametrize(("paper", "number"), NUMBERED, ids=str)
def test_equation_is_named_where_it_is_computed(paper: str, number: int) -> None:
    assert citations()[paper, number]


def test_no_docstring_names_an_equation_that_the_papers_do_not_have() -> None:
    assert set(citations()) <= set(NUMBERED)


def test_citations_are_read_in_every_form() -> None:
    assert list(cited_in("FAT eqs. 3 and 4, or FAT eq. 6")) == [("FAT", 3), ("FAT", 4), ("FAT", 6)]
    assert list(cited_in("[FAT eqs. 11-13]; NRT eq. 2 to 3")) == [("FAT", 11), ("FAT", 12), ("FAT", 13)] + [
        ("NRT", 2),
        ("NRT", 3),
    ]


def test_pages_are_those_of_this_code() -> None:
    page = (ROOT / "docs" / "architecture.md").read_text()
    assert (ROOT / "docs" / "equations.md").read_text() == equations_page()
    assert with_rooms(page) == page
