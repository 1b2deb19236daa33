"""What an importer did not understand: by name, each thing with the places where it stands; and the container that a scene is written to."""
import json
import zipfile


class Report:
    def __init__(self):
        self.unsupported, self.notes = {}, {}

    def __call__(self, what, where=None, is_note=False):
        (self.notes if is_note else self.unsupported).setdefault(what, {})[where] = None

    def document(self):
        return {kind: [{"what": what, "where": sorted(w for w in places if w)} for what, places in sorted(table.items())]
                for kind, table in (("unsupported", self.unsupported), ("notes", self.notes))}

    def lines(self):
        for kind, table in (("not converted", self.unsupported), ("note", self.notes)):
            for what, places in sorted(table.items()):
                where = ", ".join(sorted(w for w in places if w)[:5])
                yield "%s: %s%s" % (kind, what, " (%s)" % where if where else "")


def write_container(path, document, files, buffers=None):
    """An .alder: stored members without times, so that equal scenes are equal files."""
    members = {"scene.json": json.dumps(document, separators=(",", ":"), allow_nan=False).encode(), **files}
    if buffers is not None and buffers.data:
        members[buffers.name] = bytes(buffers.data)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED, allowZip64=True) as z:
        for name, data in members.items():
            z.writestr(zipfile.ZipInfo(name, date_time=(1980, 1, 1, 0, 0, 0)), data)
