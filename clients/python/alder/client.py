"""The client: scenes, assets, graphs, previews and renders of one daemon."""
from __future__ import annotations

import hashlib
import os
import sys
import threading
import time
import urllib.parse
from typing import Any, Callable, Iterable, Iterator, Mapping, Sequence, Union

from ._transport import Transport
from .daemon import LocalDaemon
from .errors import AlderError, NotAvailable, RenderFailed
from .graph import Catalogue, Graph
from .image import Image
from .live import Live

GraphLike = Union[Graph, Mapping[str, Any]]
Progress = Callable[[float, str], None]


def graph_document(graph: GraphLike) -> dict[str, Any]:
    return graph.document() if isinstance(graph, Graph) else dict(graph)


def terminal_progress(fraction: float, what: str) -> None:
    """A bar on stderr where that is a terminal."""
    if sys.stderr.isatty():
        done = int(30 * min(max(fraction, 0.0), 1.0))
        sys.stderr.write("\r%-10s [%s%s] %3d %%%s" % (what, "#" * done, "." * (30 - done), 100 * fraction, "\n" if fraction >= 1 else ""))
        sys.stderr.flush()


def quote(text: str) -> str:
    return urllib.parse.quote(text, safe="")


class Scene:
    """A scene of the daemon: scene.id, scene.materials (names), scene["body"] (its graph document)."""

    def __init__(self, client: "Client", document: dict[str, Any]):
        self.client, self.document = client, document

    @property
    def id(self) -> str:
        return str(self.document["id"])

    @property
    def materials(self) -> list[str]:
        return list(self.document.get("materials", []))

    @property
    def warnings(self) -> list[str]:
        return list(self.document.get("warnings", []))

    def _path(self, material: str) -> str:
        return "/v1/scenes/%s/materials/%s" % (self.id, quote(material))

    def __getitem__(self, material: str) -> dict[str, Any]:
        return self.client.transport.ask("GET", self._path(material)).json()

    def __setitem__(self, material: str, graph: GraphLike) -> None:
        etag = self.client.transport.ask("GET", self._path(material)).headers.get("ETag", "*")
        self.client.transport.ask("PUT", self._path(material), graph_document(graph), {"If-Match": etag})

    def delete(self) -> None:
        self.client.transport.ask("DELETE", "/v1/scenes/" + self.id)

    def __repr__(self) -> str:
        return "<alder.Scene %s: %s>" % (self.id, ", ".join(self.materials))


class Assets:
    def __init__(self, transport: Transport):
        self._transport = transport

    @staticmethod
    def digest(data: bytes) -> str:
        return "sha256:" + hashlib.sha256(data).hexdigest()

    def missing(self, digests: Iterable[str]) -> list[str]:
        """Those of the digests that the daemon lacks."""
        wanted, out = list(dict.fromkeys(digests)), []
        for i in range(0, len(wanted), 10_000):
            out += self._transport.ask("POST", "/v1/assets/missing", {"digests": wanted[i:i + 10_000]}).json()["missing"]
        return out

    def push(self, data: bytes, progress: Progress | None = None) -> str:
        """Sends the bytes unless they are there; returns the digest that documents name them by."""
        digest = self.digest(data)
        if self.missing([digest]):
            self._transport.ask("PUT", "/v1/assets/" + digest, data, {"Content-Type": "application/octet-stream"}, timeout=600)
        if progress:
            progress(1.0, "upload")
        return digest

    def get(self, digest: str) -> bytes:
        return self._transport.ask("GET", "/v1/assets/" + digest, headers={"Accept": "*/*"}).body


class Scenes:
    def __init__(self, client: "Client"):
        self._client = client

    def push(self, scene: str | os.PathLike[str] | Mapping[str, Any], progress: Progress | None = terminal_progress) -> Scene:
        """A file (.alder, .glb, .gltf, .ass) or a scene document; what the daemon has already is not sent again."""
        if isinstance(scene, Mapping):
            body: dict[str, Any] = dict(scene)
        else:
            with open(scene, "rb") as f:
                data = f.read()
            body = {"container": self._client.assets.push(data, progress)}
        return Scene(self._client, self._client.transport.ask("POST", "/v1/scenes", body, timeout=600).json())

    def get(self, id: str) -> Scene:
        return Scene(self._client, self._client.transport.ask("GET", "/v1/scenes/" + id).json())


class Job:
    """A render: job.state, job.progress, job.images(), job.result(), job.cancel().

    Where the daemon keeps renders (202), the job follows it there; where it only renders within the request, the request runs in
    a thread of this process and the job waits for it.
    """

    def __init__(self, client: "Client", body: dict[str, Any], wait_seconds: float):
        self._client, self._body, self._wait = client, body, wait_seconds
        self._image: Image | None = None
        self._error: BaseException | None = None
        self._done = threading.Event()
        self._document: dict[str, Any] = {}
        self._cancelled = False
        self._start()

    def _start(self) -> None:
        transport = self._client.transport
        try:
            answer = transport.ask("POST", "/v1/renders", self._body, {"Accept": "application/json"})
        except NotAvailable:
            threading.Thread(target=self._within_request, daemon=True).start()
            return
        self._document = answer.json()

    def _within_request(self) -> None:
        try:
            answer = self._client.transport.ask("POST", "/v1/renders", self._body, {"Accept": "image/x-exr", "Prefer": "wait=%g" % self._wait},
                                                timeout=self._wait + 30)
            self._image = Image.from_bytes(answer.body)
        except BaseException as e:  # noqa: B902 - handed to whoever waits
            self._error = e
        self._done.set()

    @property
    def id(self) -> str | None:
        return self._document.get("id")

    @property
    def state(self) -> str:
        if self.id is None:
            return "rendering" if not self._done.is_set() else "failed" if self._error else "succeeded"
        if self._document.get("state") not in ("succeeded", "failed", "cancelled"):
            self.refresh()
        return str(self._document.get("state"))

    @property
    def progress(self) -> float:
        if self.id is None:
            return 1.0 if self._done.is_set() else 0.0
        return float(self.refresh().get("progress", {}).get("fraction", 0.0))

    def refresh(self) -> dict[str, Any]:
        if self.id is not None:
            self._document = self._client.transport.ask("GET", "/v1/renders/" + self.id).json()
        return self._document

    def cancel(self) -> None:
        if self.id is None:
            raise NotAvailable("this daemon renders within the request; it ends when the request does")
        self._client.transport.ask("POST", "/v1/renders/%s/cancel" % self.id)

    def images(self, seconds: float = 0.5) -> Iterator[Image]:
        """Pictures of growing quality, the newest each time, the final one last."""
        last = -1
        while self.id is not None and self.state not in ("succeeded", "failed", "cancelled"):
            try:
                image = Image.from_bytes(self._client.transport.ask("GET", "/v1/renders/%s/snapshot.exr" % self.id, headers={"Accept": "image/x-exr"}).body)
                if image.samples != last:
                    last = image.samples if image.samples is not None else -1
                    yield image
            except AlderError:
                pass   # nothing to see yet
            time.sleep(seconds)
        yield self.result()

    def result(self, timeout: float | None = None, progress: Progress | None = terminal_progress) -> Image:
        """The finished picture; raises what the render ended with."""
        deadline = None if timeout is None else time.monotonic() + timeout
        if self.id is None:
            if not self._done.wait(timeout):
                raise TimeoutError("the render is not finished after %g s" % (timeout or 0))
            if self._error:
                raise self._error
            assert self._image is not None
            return self._image
        if self._image is not None:
            return self._image
        transport, etag = self._client.transport, ""
        while self._document.get("state") not in ("succeeded", "failed", "cancelled"):
            if deadline is not None and time.monotonic() > deadline:
                raise TimeoutError("the render is not finished after %g s" % (timeout or 0))
            wait = 10.0 if deadline is None else max(0.1, min(10.0, deadline - time.monotonic()))
            answer = transport.ask("GET", "/v1/renders/" + str(self.id), headers={"Prefer": "wait=%g" % max(1, round(wait)), "If-None-Match": etag} if etag else None)
            if answer.status == 200:
                self._document = answer.json()
                etag = answer.headers.get("ETag", "")
                if progress:
                    progress(float(self._document.get("progress", {}).get("fraction", 0.0)), "render")
                if not etag:
                    time.sleep(0.2)
        if self._document["state"] != "succeeded":
            raise RenderFailed("render %s: %s%s" % (self.id, self._document["state"], ": %s" % self._document["reason"] if self._document.get("reason") else ""),
                               problem=self._document.get("error") or {})
        names = [o["file"] for o in self._document.get("outputs", []) if o["file"].endswith(".exr")]
        path = "/outputs/" + quote(names[0]) if names else "/snapshot.exr"
        self._image = Image.from_bytes(transport.ask("GET", "/v1/renders/%s%s" % (self.id, path), headers={"Accept": "*/*"}, timeout=600).body)
        return self._image

    def _repr_png_(self) -> bytes | None:
        return self._image._repr_png_() if self._image is not None else None

    def __repr__(self) -> str:
        return "<alder.Job %s: %s>" % (self.id or "within its request", self.state)


class Client:
    """with alder.connect() as c: ...; one client may be used from several threads."""

    def __init__(self, url: str, token: str | None = None, timeout: float = 60.0, daemon: LocalDaemon | None = None):
        self.transport = Transport(url, token, timeout)
        self.assets = Assets(self.transport)
        self.scenes = Scenes(self)
        self._daemon = daemon
        self._catalogue: Catalogue | None = None

    @property
    def url(self) -> str:
        return self.transport.url

    def version(self) -> dict[str, Any]:
        return self.transport.ask("GET", "/v1/version").json()

    @property
    def nodes(self) -> Catalogue:
        """The node catalogue of this daemon, read once."""
        if self._catalogue is None:
            items: list[dict[str, Any]] = []
            cursor: str | None = ""
            while cursor is not None:
                page = self.transport.ask("GET", "/v1/nodes" + ("?cursor=" + quote(cursor) if cursor else "")).json()
                items += page["items"]
                cursor = page.get("next") or None
            self._catalogue = Catalogue(items)
        return self._catalogue

    def graph(self) -> Graph:
        """An empty graph whose nodes are completed and checked by this daemon's catalogue."""
        return Graph(self.nodes)

    def validate(self, graph: GraphLike) -> dict[str, Any]:
        return self.transport.ask("POST", "/v1/graphs/validate", {"graph": graph_document(graph)}).json()

    def evaluate(self, graph: GraphLike, points: Mapping[str, Any], outputs: Sequence[str], **members: Any) -> dict[str, Any]:
        """Values of outputs at points, without a scene."""
        body = {"graph": graph_document(graph), "points": {k: v.tolist() if hasattr(v, "tolist") else v for k, v in points.items()}, "outputs": list(outputs), **members}
        return self.transport.ask("POST", "/v1/evaluate", body, timeout=600).json()

    def preview(self, graph: GraphLike, stage: str = "shaderball", size: int = 256, samples: int = 16, **members: Any) -> Image:
        """The graph on a preview stage."""
        body = {"graph": graph_document(graph), "stage": stage, "size": size, "samples": samples, **members}
        if "budget" in members:
            del body["samples"]
        return Image.from_bytes(self.transport.ask("POST", "/v1/preview", body, {"Accept": "image/x-exr"}, timeout=600).body)

    def render(self, scene: Scene | str, *, wait_seconds: float = 3600.0, **members: Any) -> Job:
        """Starts a render: samples=, resolution=, aovs=, stop=, crop= ... as POST /v1/renders takes them."""
        return Job(self, {"scene": scene.id if isinstance(scene, Scene) else scene, **members}, wait_seconds)

    def live(self, scene: Scene | str, size: tuple[int, int] | None = None, **members: Any) -> Live:
        """A picture that follows edits of the scene."""
        return Live(self.transport, scene.id if isinstance(scene, Scene) else scene, size, members)

    def close(self) -> None:
        self.transport.close()
        if self._daemon is not None:
            self._daemon.close()

    def __enter__(self) -> "Client":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return "<alder.Client %s>" % self.url


def local(*options: str, program: str | None = None) -> Client:
    """Starts an alderd for this process; it ends with the client. `options` are the daemon's."""
    daemon = LocalDaemon(program, options)
    return Client(daemon.url, daemon=daemon)


def connect(url: str | None = None, token: str | None = None, timeout: float = 60.0) -> Client:
    """The daemon at `url`, else at $ALDER_URL, else one that answers at the default address, else a new one for this process.

    The token: `token`, else the first line of the file that $ALDER_TOKEN_FILE names.
    """
    if token is None and os.environ.get("ALDER_TOKEN_FILE"):
        with open(os.environ["ALDER_TOKEN_FILE"]) as f:
            token = f.readline().strip()
    url = url or os.environ.get("ALDER_URL")
    if url:
        return Client(url, token, timeout)
    client = Client("http://127.0.0.1:7420", token, timeout)
    client.transport.retries = 0
    try:
        if "alder" in str(client.version().get("name", "")):
            client.transport.retries = 4
            return client
    except (AlderError, ValueError):
        pass
    return local()
