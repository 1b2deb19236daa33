"""Client of the Alder render daemon.

    import alder
    with alder.connect() as c:
        scene = c.scenes.push("shot.alder")
        image = c.render(scene, samples=64, aovs=["shading"]).result()
        image.save("shot.exr")
"""
from . import aio, tiles
from .client import Client, Job, Scene, connect, local
from .errors import AlderError, Busy, Conflict, Denied, Invalid, NotAvailable, NotFound, RenderFailed, Unreachable
from .graph import Catalogue, Graph, Link, Node
from .image import Image
from .live import Live

__version__ = "0.1.0"
__all__ = ["AlderError", "Busy", "Catalogue", "Client", "Conflict", "Denied", "Graph", "Image", "Invalid", "Job", "Link", "Live", "Node",
           "NotAvailable", "NotFound", "RenderFailed", "Scene", "Unreachable", "aio", "connect", "local", "tiles"]
