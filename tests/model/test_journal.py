"""The journal: whatever is torn off its end, every earlier entry is there; a failed write leaves no trace."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from rgcore.errors import ProjectError
from rgcore.model.edits import ClassifyRegion, MoveGateway, RenameRegion
from rgcore.model.history import AnyEntry, Do, Redo, Undo
from rgcore.model.journal import Journal, encode_journal, encode_line

AT = "2026-01-01T00:00:00Z"
ENTRIES: list[AnyEntry] = [
    Do(number=1, at=AT, by="ann", edit=RenameRegion(region="r1", name='Büro "Nord" \\ 1')),
    Do(number=2, at=AT, edit=MoveGateway(gateway="g1", posts=((0.1, 1 / 3), (1e-7, -2.5)))),
    Undo(number=3, at=AT, by="bob"),
    Redo(number=4, at=AT),
]
DATA = encode_journal(ENTRIES)
NEXT = Do(number=5, at=AT, edit=ClassifyRegion(region="r1", class_="CC"))


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "edits.jsonl"


def test_what_is_appended_is_read_back(path: Path) -> None:
    path.touch()
    journal = Journal(path)
    for number, entry in enumerate(ENTRIES, 1):
        assert journal.next_number == number
        journal.append(entry)
        assert Journal(path).entries == ENTRIES[:number]  # on the disk before `append` returned
    assert path.read_bytes() == DATA


def test_torn_at_every_byte_all_earlier_entries_are_there(path: Path) -> None:
    ends = [0]
    for entry in ENTRIES:
        ends.append(ends[-1] + len(encode_line(entry)))
    for cut in range(len(DATA) + 1):
        path.write_bytes(DATA[:cut])
        journal = Journal(path)
        whole = sum(cut >= end - 1 for end in ends[1:])  # all of a line but its newline is a whole entry
        assert journal.entries == ENTRIES[:whole], cut
        torn = DATA[ends[whole] : cut]
        assert [f"({len(torn)} bytes)" in note for note in journal.notes] == [True] * bool(torn)


@pytest.mark.parametrize("cut", range(len(DATA) - len(encode_line(ENTRIES[-1])), len(DATA) + 1))
def test_after_a_tear_the_journal_goes_on_and_keeps_the_torn_end(path: Path, cut: int) -> None:
    path.write_bytes(DATA[:cut])
    journal = Journal(path)
    before = list(journal.entries)
    torn = DATA[len(encode_journal(before)) : cut]
    journal.append(NEXT)
    journal.close()
    again = Journal(path)
    assert again.entries == [*before, NEXT]
    assert again.notes == []
    aside = path.with_name("edits.jsonl.torn")
    assert (aside.read_bytes() if aside.exists() else b"") == (torn + b"\n" if torn else b"")


def test_zeros_after_a_power_cut_are_a_torn_end(path: Path) -> None:
    path.write_bytes(DATA + b"\0" * 4096)
    journal = Journal(path)
    assert journal.entries == ENTRIES
    journal.append(NEXT)
    assert path.read_bytes() == DATA + encode_line(NEXT)


def test_no_flipped_bit_gives_a_wrong_entry(path: Path) -> None:
    """Damage before the last entry is told with file and line; nothing is ever read that was not written."""
    told = []
    for i in range(0, len(DATA), 3):
        damaged = bytearray(DATA)
        damaged[i] ^= 1 << (i % 8)
        path.write_bytes(damaged)
        try:
            entries = Journal(path).entries
        except ProjectError as e:
            told.append(str(e))
        else:
            assert entries == ENTRIES[: len(entries)]
    assert len(told) > 50
    assert all("edits.jsonl:" in text for text in told)


def test_a_damaged_entry_in_the_middle_is_named(path: Path) -> None:
    path.write_bytes(DATA.replace(b"Nord", b"Sued"))
    with pytest.raises(ProjectError, match=r"edits\.jsonl:1: this entry is damaged; restore the file"):
        Journal(path)


def test_entries_of_a_newer_version_are_not_taken_for_damage(path: Path) -> None:
    class FoldRegion(ClassifyRegion, frozen=True):
        pass

    newer = Do(number=1, at=AT, edit=FoldRegion(region="r1", class_="CC"))  # type: ignore[arg-type]
    path.write_bytes(encode_line(newer))
    with pytest.raises(ProjectError, match=r"edits\.jsonl:1: .*FoldRegion.*upgrade"):
        Journal(path)


def test_entries_out_of_order_are_refused(path: Path) -> None:
    path.write_bytes(encode_journal([ENTRIES[1], ENTRIES[0]]))
    with pytest.raises(ProjectError, match="entry 1 stands after entry 2"):
        Journal(path)


def test_a_missing_journal_is_told_with_the_remedy(path: Path) -> None:
    with pytest.raises(ProjectError, match=r"edits\.jsonl: cannot read the journal: No such file.*make an empty file"):
        Journal(path)


@pytest.mark.parametrize("failing", ["write", "fsync"])
def test_a_failed_write_leaves_the_journal_as_it_was(path: Path, failing: str, monkeypatch: pytest.MonkeyPatch) -> None:
    path.write_bytes(DATA)
    journal = Journal(path)
    real_write, real_fsync = os.write, os.fsync
    calls = []

    def full(fd: int, data: bytes) -> int:
        calls.append(fd)
        if len(calls) > 1:
            raise OSError(errno.ENOSPC, "No space left on device")
        return real_write(fd, data[:10])  # a part of it still fits

    def broken(fd: int) -> None:
        calls.append(fd)
        if len(calls) == 1:
            raise OSError(errno.EIO, "Input/output error")
        real_fsync(fd)

    with monkeypatch.context() as patch:
        patch.setattr(os, failing, full if failing == "write" else broken)
        with pytest.raises(ProjectError, match=r"the edit was not kept: .*make room and try again"):
            journal.append(NEXT)
    assert path.read_bytes() == DATA
    assert journal.entries == ENTRIES
    journal.append(NEXT)
    assert Journal(path).entries == [*ENTRIES, NEXT]
