"""Edits of notes: what people write down at a place of the map, or on an item of it."""

from __future__ import annotations

from rgcore.model.edit import Edit, drop, kind_of, must_be_new, put, the_note
from rgcore.model.fields import AnyId, NewNoteId, NoteId, NoteText, Place
from rgcore.model.records import Note, RGMap, replace


class AddNote(Edit, frozen=True):
    """There is a note at this place, perhaps on an item."""

    id: NewNoteId
    text: NoteText
    place: Place
    item: AnyId | None = None

    def change(self, map: RGMap) -> RGMap:
        must_be_new(map, "notes", self.id)
        if self.item is not None:
            kind_of(map, self.item)
        return put(map, "notes", Note(id=self.id, text=self.text, place=self.place, item=self.item))

    def title(self, map: RGMap) -> str:
        return f"add a note on {self.item}" if self.item else "add a note"


class WriteNote(Edit, frozen=True):
    """A note says this."""

    note: NoteId
    text: NoteText

    def change(self, map: RGMap) -> RGMap:
        return put(map, "notes", replace(the_note(map, self.note), text=self.text))

    def title(self, map: RGMap) -> str:
        return f"change the note {self.note}"


class MoveNote(Edit, frozen=True):
    """A note stands here."""

    note: NoteId
    place: Place

    def change(self, map: RGMap) -> RGMap:
        return put(map, "notes", replace(the_note(map, self.note), place=self.place))

    def title(self, map: RGMap) -> str:
        return f"move the note {self.note}"


class DeleteNote(Edit, frozen=True):
    """There is no such note."""

    note: NoteId

    def change(self, map: RGMap) -> RGMap:
        return drop(map, "notes", the_note(map, self.note).id)

    def title(self, map: RGMap) -> str:
        return f"delete the note {self.note}"
