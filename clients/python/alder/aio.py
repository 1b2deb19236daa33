"""The same with await: each call runs in a thread of the event loop's executor.

    async with await alder.aio.connect() as c:
        scene = await c.scenes.push("shot.alder")
        image = await (await c.render(scene, samples=64)).result()
"""
from __future__ import annotations

import asyncio
from typing import Any, AsyncIterator

from . import client as _sync
from .image import Image
from .live import Live as _Live

_END = object()


class _Async:
    """Methods of the wrapped object with await; attributes that are no methods as they are."""

    def __init__(self, sync: Any):
        self._sync = sync

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._sync, name)
        if not callable(value):
            return wrap(value)

        async def call(*args: Any, **kwargs: Any) -> Any:
            args = tuple(a._sync if isinstance(a, _Async) else a for a in args)
            return wrap(await asyncio.to_thread(value, *args, **kwargs))
        return call

    async def __aenter__(self) -> "_Async":
        return self

    async def __aexit__(self, *_: object) -> None:
        await asyncio.to_thread(self._sync.close)

    def __repr__(self) -> str:
        return repr(self._sync)


class Job(_Async):
    async def images(self, seconds: float = 0.5) -> AsyncIterator[Image]:
        pictures = self._sync.images(seconds)
        while (image := await asyncio.to_thread(next, pictures, _END)) is not _END:
            yield image


class Live(_Async):
    async def set(self, target: str, value: Any) -> None:
        await asyncio.to_thread(self._sync.__setitem__, target, value)


def wrap(value: Any) -> Any:
    if isinstance(value, _sync.Job):
        return Job(value)
    if isinstance(value, _Live):
        return Live(value)
    if isinstance(value, (_sync.Client, _sync.Scene, _sync.Scenes, _sync.Assets)):
        return _Async(value)
    return value


async def connect(url: str | None = None, token: str | None = None, timeout: float = 60.0) -> Any:
    return wrap(await asyncio.to_thread(_sync.connect, url, token, timeout))


async def local(*options: str, program: str | None = None) -> Any:
    return wrap(await asyncio.to_thread(lambda: _sync.local(*options, program=program)))
