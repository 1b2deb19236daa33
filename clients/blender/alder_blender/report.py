"""What an export could not carry over: collected by name while it goes on, told once at the end."""


class ExportError(Exception):
    """The scene cannot be exported at all; the message says why."""


class Report:
    """`unsupported`: the picture will differ. `notes`: it may differ, or nothing but noise does."""

    def __init__(self):
        self._unsupported = {}
        self._notes = {}

    def unsupported(self, what, where=None):
        self._unsupported.setdefault(what, {})[where] = None

    def note(self, what, where=None):
        self._notes.setdefault(what, {})[where] = None

    @staticmethod
    def _entries(table):
        return [{"what": what, "where": sorted(w for w in places if w is not None)} for what, places in sorted(table.items())]

    def __bool__(self):
        return bool(self._unsupported)

    def document(self):
        return {"unsupported": self._entries(self._unsupported), "notes": self._entries(self._notes)}

    def lines(self, most=5):
        """One line a thing: what, and the first places where."""
        out = []
        for kind, table in (("not exported", self._unsupported), ("note", self._notes)):
            for e in self._entries(table):
                places = e["where"]
                more = ", and %d more" % (len(places) - most) if len(places) > most else ""
                out.append("%s: %s%s" % (kind, e["what"], " (%s%s)" % (", ".join(places[:most]), more) if places else ""))
        return out
