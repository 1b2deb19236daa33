"""A scene of a daemon, and a live render of it, that follow a document: only what differs is sent. Without Blender in it.

The document may be set from one thread at any rate; a thread of the mirror's own talks to the daemon, and what was overtaken while it
did is never sent. Pictures come in another thread, the newest replaces the one before.
"""
import hashlib
import threading
import time
import urllib.parse
import uuid

from .backend import client_package

NOTHING = object()
STREAM_SECONDS = 3600.0   # a picture that is finished sends nothing


class Box:
    """What container.Container is for files: arrays and images as assets of a daemon, each sent once, in one piece for each export."""

    def __init__(self):
        self._known = {}      # (digest of the numbers, type, channels) -> entry of the document
        self._fresh = []      # (offset, array, entries to be named) of the piece in the making
        self._bytes = 0
        self._files = {}      # name -> digest
        self._pieces = {}     # digest -> bytes that the daemon may lack

    def array(self, values, channels):
        import numpy as np
        from .container import ALIGN, TYPES
        values = np.ascontiguousarray(values)
        values = values.astype(values.dtype.newbyteorder("<"), copy=False)
        data = memoryview(values).cast("B") if values.size else b""
        key = (hashlib.blake2b(data, digest_size=16).digest(), values.dtype.str, channels)
        entry = self._known.get(key)
        if entry is None:
            self._bytes += -self._bytes % ALIGN
            entry = self._known[key] = {"buffer": None, "type": TYPES[values.dtype], "offset": self._bytes, "count": values.size // channels}
            self._fresh.append((self._bytes, bytes(data), entry))
            self._bytes += len(data)
        return entry

    def file(self, name, data):
        digest = self._files[name] = "sha256:" + hashlib.sha256(data).hexdigest()
        self._pieces[digest] = bytes(data)

    def has(self, name):
        return name in self._files

    def reference(self, name):
        return {"asset": self._files[name]}

    def take(self):
        """Ends an export: names its arrays' buffer, and gives what is new as {digest: bytes}."""
        if self._fresh:
            piece, at = bytearray(self._bytes), 0
            for at, data, _ in self._fresh:
                piece[at:at + len(data)] = data
            digest = "sha256:" + hashlib.sha256(piece).hexdigest()
            for _, _, entry in self._fresh:
                entry["buffer"] = digest
            self._pieces[digest] = bytes(piece)
            self._fresh, self._bytes = [], 0
        pieces, self._pieces = self._pieces, {}
        return pieces


def difference(old, new):
    """The merge patch (RFC 7396) from old to new, or NOTHING where they are equal."""
    if old is new:
        return NOTHING
    if not isinstance(old, dict) or not isinstance(new, dict):
        return NOTHING if old == new and type(old) is type(new) else new
    patch = {}
    for key, value in new.items():
        if key not in old:
            patch[key] = value
            continue
        d = difference(old[key], value)
        if d is not NOTHING:
            patch[key] = d
    for key in old:
        if key not in new:
            patch[key] = None
    return patch if patch else NOTHING


class Mirror:
    """`client`: gives the alder.Client; it is called in the mirror's thread, for starting a daemon takes a while."""

    def __init__(self, client, size, max_samples=1024, layers=()):
        self.alder = client_package()
        self._make_client = client
        self.client = None
        self._condition = threading.Condition()
        self._wanted = None            # (document, size, max_samples)
        self._size, self._max_samples = tuple(size), max_samples
        self._layers = tuple(layers)
        self._pieces = {}              # assets that a document needs and the daemon may lack
        self._sent = None
        self._scene = self._render = None
        self._stream = None
        self._closing = self._busy = False
        self._patches_scenes = True    # until the daemon says otherwise
        self._edits = {}               # token -> when its edit was wanted
        self._wanted_at = 0.0
        self.picture = None            # the newest, a tiles.Picture
        self.error = None              # what stands in the way, as text
        self.warnings = []
        self.sent_seconds = None       # from the last edit to the daemon's answer
        self.latency = None            # from the last edit to the first picture that shows it
        self._thread = threading.Thread(target=self._run, name="alder mirror", daemon=True)
        self._thread.start()

    # ---- what others call ----

    def show(self, document, pieces=None):
        """The document must not change afterwards; a later one may share parts with it, which are then known to be equal."""
        with self._condition:
            self._pieces.update(pieces or {})
            self._wanted = document
            self._wanted_at = time.perf_counter()
            self._condition.notify_all()

    def resize(self, size, max_samples):
        with self._condition:
            if (tuple(size), max_samples) != (self._size, self._max_samples):
                self._size, self._max_samples = tuple(size), max_samples
                self._condition.notify_all()

    def wait(self, seconds=10.0):
        """Until a picture shows all edits; False where it does not in time."""
        with self._condition:
            return self._condition.wait_for(lambda: self._wanted is None and not self._busy and not self._edits and self.picture is not None or self.error, seconds) and not self.error

    def close(self):
        with self._condition:
            self._closing = True
            self._condition.notify_all()
        if self._stream is not None:
            self._stream.close()

    # ---- the thread that sends ----

    def _run(self):
        size = None
        while True:
            with self._condition:
                self._condition.wait_for(lambda: self._closing or self._wanted is not None or (self._render is not None and size != (self._size, self._max_samples)))
                if self._closing:
                    break
                document, self._wanted, since = self._wanted, None, self._wanted_at
                pieces, self._pieces = self._pieces, {}
                before, size = size, (self._size, self._max_samples)
                self._busy = True
            try:
                if self.client is None:
                    self.client = self._make_client()
                if self._render is not None and before != size:
                    self._ask("PATCH", "/v1/renders/" + self._render, {"resolution": list(size[0]), "max_samples": size[1]})
                if document is not None:
                    for digest, data in pieces.items():
                        self.client.assets.push(data)
                    self._bring(document, since)
                self.error = None
            except Exception as e:   # shown to the user; the next edit is another try
                with self._condition:
                    self._pieces = {**pieces, **self._pieces}   # what was not sent is sent next time
                    self.error = str(e) or type(e).__name__
                    self._edits.clear()
            with self._condition:
                self._busy = False
                self._condition.notify_all()
        self._forget(self._render, self._scene)

    def _ask(self, method, path, body, **headers):
        return self.client.transport.ask(method, path, body, {k.replace("_", "-"): v for k, v in headers.items()})

    def _bring(self, document, since):
        patch = difference(self._sent, document) if self._sent is not None else document
        if patch is NOTHING:
            return
        if self._sent is None or not self._edit(patch, document, since):
            self._replace(document, since)
        self._sent = document
        self.sent_seconds = time.perf_counter() - since

    def _token(self, since):
        token = uuid.uuid4().hex[:16]
        with self._condition:
            self._edits[token] = since
        return token

    def _edit(self, patch, document, since):
        """False where the daemon cannot do it to the scene that it has."""
        materials = patch.get("materials", {})
        whole = self._sent["materials"]
        if set(patch) == {"materials"} and all(isinstance(p, dict) and name in whole for name, p in materials.items()):
            token = self._token(since)   # one picture shows them all: the last one's
            for i, (name, p) in enumerate(materials.items()):
                path = "/v1/scenes/%s/materials/%s" % (self._scene, urllib.parse.quote(name, safe=""))
                more = {"Alder_Edit_Id": token} if i == len(materials) - 1 else {}
                try:
                    self._ask("PATCH", path, p, Content_Type="application/merge-patch+json", If_Match="*", **more)
                except self.alder.Invalid:   # where the stored graph has another form than the one sent
                    self._ask("PUT", path, document["materials"][name], If_Match="*", **more)
            return True
        if not self._patches_scenes:
            return False
        token = self._token(since)
        try:
            self._ask("PATCH", "/v1/scenes/" + self._scene, patch, Content_Type="application/merge-patch+json", If_Match="*", Alder_Edit_Id=token)
            return True
        except (self.alder.NotAvailable, self.alder.NotFound):
            self._patches_scenes = False
        except self.alder.Invalid:
            pass   # the whole document will say it better
        with self._condition:
            self._edits.pop(token, None)
        return False

    def _replace(self, document, since):
        """Another scene and render in place of those that are there; their picture stays until there is a new one."""
        scene = self._ask("POST", "/v1/scenes?lenient=true", document).json()
        old = self._render, self._scene
        size, samples = self._size, self._max_samples
        try:
            render = self._ask("POST", "/v1/renders", {"scene": scene["id"], "mode": "live", "resolution": list(size), "max_samples": samples, "lenient": True,
                                                       **({"aovs": list(self._layers)} if self._layers else {})}).json()
        except Exception:
            self._forget(None, scene["id"])
            raise
        self.warnings = [w for w in scene.get("warnings", []) if "not-exported" not in w]
        self._scene, self._render = scene["id"], render["id"]
        with self._condition:
            self._edits.clear()
            self._edits["first"] = since
        if self._stream is not None:
            self._stream.close()
        threading.Thread(target=self._follow, args=(self._render,), name="alder pictures", daemon=True).start()
        self._forget(*old)

    def _forget(self, render, scene):
        for path in ("/v1/renders/%s" % render if render else "", "/v1/scenes/%s" % scene if scene else ""):
            if path:
                try:
                    self.client.transport.ask("DELETE", path)
                except (self.alder.AlderError, OSError):
                    pass   # it ends by itself

    # ---- the thread that receives ----

    def _follow(self, render):
        tiles = self.alder.tiles
        while not self._closing and render == self._render:
            try:
                path_layers = ("rgba", *self._layers) if self._layers else ()
                stream = tiles.open_stream(self.client.transport, render, path_layers, timeout=STREAM_SECONDS)
                self._stream = stream
                if self._closing or render != self._render:
                    stream.close()
                    return
                for picture in tiles.read(stream):
                    self._take(render, picture)
            except (self.alder.AlderError, OSError, ValueError, AttributeError, EOFError):
                pass   # the connection broke, or the render ended and another one is coming
            if not self._closing and render == self._render:
                time.sleep(0.2)

    def _take(self, render, picture):
        now = time.perf_counter()
        with self._condition:
            if render != self._render or self._closing:
                return
            self.picture = picture
            for token in (*picture.edits, "first"):
                if token in self._edits:
                    self.latency = now - self._edits.pop(token)
            self._condition.notify_all()
