from core.progress import Job, Progress, forwards, part, run


def count(n: int) -> Job[int]:
    for i in range(n):
        yield Progress(i / n, f"step {i}")
    return n


def test_run_returns_the_result_and_reports_every_step() -> None:
    seen: list[Progress] = []
    assert run(count(4), seen.append) == 4
    assert [p.fraction for p in seen] == [0, 0.25, 0.5, 0.75]


def test_a_part_takes_its_share_of_the_whole() -> None:
    def whole() -> Job[int]:
        first = yield from part(count(2), 0.0, 0.5)
        second = yield from part(count(2), 0.5, 1.0)
        return first + second

    seen: list[Progress] = []
    assert run(whole(), seen.append) == 4
    assert [p.fraction for p in seen] == [0, 0.25, 0.5, 0.75]


def test_progress_of_parts_in_any_order_runs_forwards() -> None:
    def whole() -> Job[int]:
        second = yield from part(count(2), 0.5, 1.0)
        return second + (yield from part(count(2), 0.0, 0.5))

    seen: list[Progress] = []
    assert run(forwards(whole()), seen.append) == 4
    assert [(p.fraction, p.note) for p in seen] == [
        (0.5, "step 0"),
        (0.75, "step 1"),
        (0.75, "step 0"),
        (0.75, "step 1"),
    ]
