"""The last step of a video: whoever does its last chunk joins the segments."""

from collections.abc import Sequence

from app.batch import records
from app.batch.look import Look
from app.batch.plan import Chunk
from app.batch.sound import sound_of
from app.batch.video_out import join
from app.batch.work import form_of, segment_of
from core.files.atomic import AtomicFiles


def reopen(chunks: Sequence[Chunk]) -> None:
    """Forget that a video was joined unless all of its chunks still are what it was joined from."""
    batch = chunks[0].batch
    if not all(records.done(batch, chunk.name, []) for chunk in chunks):
        (batch.records / f"{records.JOINED}.json").unlink(missing_ok=True)


def join_segments(chunks: Sequence[Chunk]) -> bool:
    """Write the video if every chunk of it is there and it is not, and return whether it is there.

    The segments go once none of them holds a frame that failed.
    """
    batch = chunks[0].batch
    with records.hold_back(batch, "joining"):
        if records.done(batch, records.JOINED, [batch.output]) is not None:
            return True
        segments = {segment_of(chunk): [item.pts for item in chunk.items] for chunk in chunks}
        if not all(segment.is_file() for segment in segments):
            return False
        with AtomicFiles() as files:
            with files.place(batch.output) as place:
                form = form_of(batch, Look(batch).base)
                join(segments, form, place, named=batch.output, sound=sound_of(chunks))
            records.note(files, batch, records.JOINED, [], [])
        if all(records.done(batch, chunk.name, []) for chunk in chunks):
            for segment in segments:
                segment.unlink(missing_ok=True)
        else:
            (batch.records / f"{records.JOINED}.json").unlink(missing_ok=True)
        return True
