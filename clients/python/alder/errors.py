"""What can go wrong, by kind. Each error keeps the daemon's problem document (RFC 9457): type, title, detail, pointers."""
from __future__ import annotations

from typing import Any


class AlderError(Exception):
    """Base of all. `status` is HTTP's, or 0 where no answer came; `type` as in "/problems/graph-invalid"."""

    def __init__(self, message: str, status: int = 0, problem: dict[str, Any] | None = None, request_id: str | None = None):
        super().__init__(message)
        self.status = status
        self.problem = problem or {}
        self.request_id = request_id

    @property
    def type(self) -> str:
        return str(self.problem.get("type", "")).rsplit("/", 1)[-1]

    @property
    def errors(self) -> list[dict[str, Any]]:
        """One entry a fault: pointer, code, found, expected, suggest."""
        return list(self.problem.get("errors", []))


class Invalid(AlderError):
    """The graph, scene or settings are wrong; `errors` says where, by JSON Pointer."""


class NotFound(AlderError):
    """No such thing, or not any more."""


class Conflict(AlderError):
    """The thing has changed meanwhile, or is in a state that does not allow this."""


class Denied(AlderError):
    """The token is missing, wrong, or not enough."""


class Busy(AlderError):
    """Full, draining or too many requests: worth a retry. `retry_after` in seconds, if the daemon said so."""

    retry_after: float | None = None


class RenderFailed(AlderError):
    """The render ended without a picture."""


class NotAvailable(AlderError):
    """This daemon does not have the feature."""


class Unreachable(AlderError):
    """No daemon answers."""


_BY_STATUS = {400: Invalid, 413: Invalid, 415: Invalid, 422: Invalid, 401: Denied, 403: Denied, 404: NotFound, 410: NotFound, 409: Conflict,
              412: Conflict, 428: Conflict, 405: NotAvailable, 501: NotAvailable, 429: Busy, 503: Busy, 507: Busy}
_BY_TYPE = {"not-available": NotAvailable, "render-crashed": RenderFailed, "out-of-memory": RenderFailed, "deadline": RenderFailed,
            "nonfinite": RenderFailed, "asset-unreadable": RenderFailed, "cancelled": RenderFailed}


def line(error: dict[str, Any]) -> str:
    """One fault as a sentence."""
    text = "%s: %s" % (error.get("pointer", "") or "/", error.get("code", "wrong"))
    if error.get("found") not in (None, ""):
        text += ", found %s" % error["found"]
    if error.get("expected"):
        text += ", expected %s" % error["expected"]
    if error.get("suggest"):
        text += "; did you mean '%s'?" % error["suggest"]
    return text


def from_problem(status: int, problem: dict[str, Any], request_id: str | None = None, retry_after: float | None = None) -> AlderError:
    kind = str(problem.get("type", "")).rsplit("/", 1)[-1]
    cls = _BY_TYPE.get(kind) or _BY_STATUS.get(status, AlderError)
    text = str(problem.get("title", "HTTP %d" % status))
    if problem.get("detail"):
        text += ": %s" % problem["detail"]
    for e in problem.get("errors", [])[:10]:
        text += "\n  " + line(e)
    error = cls(text, status, problem, request_id)
    if isinstance(error, Busy):
        error.retry_after = retry_after
    return error
