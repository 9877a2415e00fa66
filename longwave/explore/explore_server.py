"""``longwave explore``: a server that shows the page to its user alone, until Ctrl-C.

Pages of other hosts may send requests here, even under a host name of their own that resolves to
this machine, and so may other users of the machine. So a request is answered only if it names this
server as its host and carries the token from the printed address. The page's websocket carries the
token as well, and its origin is checked.
"""

from __future__ import annotations

import hmac
import logging
import secrets
import signal
import socket
import sys
import tempfile
import threading
import webbrowser
from collections.abc import Iterator
from contextlib import closing, contextmanager, nullcontext
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from longwave.support.command_line import fail
from longwave.support.interruption import ENDING, interrupted
from longwave.support.request_limits import RequestLimits, current_limits
from longwave.support.slow_work import count_notice

if TYPE_CHECKING:
    from longwave.explore.explore_page import ExplorePage

HOST = "127.0.0.1"
"""Loopback address, which cannot be reached from other machines."""

MOST_PAGES, MOST_SESSIONS = 10, 50
"""Largest number of pages shown at a time, each with its own process; and of sessions, which
include pages that are not yet shown or were closed recently."""

TOO_MANY = f"at most {MOST_PAGES} pages may be open: close one, and reload"

CLOSED_PAGE_MS = 60_000
"""Milliseconds after which a closed page is discarded and its process stopped. A page whose browser
takes longer than this to connect is discarded too."""

TOKEN_KEY = "token"
"""Name of the token in the address."""

LOCAL_STYLE_SHEETS = "static/extensions/panel/"
"""Path of Panel's style sheets on this server."""


def explore(port: int, browser: bool, program: str) -> int:
    """Serve the page until Ctrl-C; return the exit status.

    The status is 130 after Ctrl-C, 2 if the port is taken, 1 if a required package is missing. With
    ``port`` 0 any free port is used.
    """
    try:
        import panel as pn
        from latex2mathml import converter  # noqa: F401  (asked for with the page)
    except ImportError as error:
        missing = (error.name or "panel").partition(".")[0]
        remedy = "pip install 'longwave[explore]'"
        print(f"error: longwave explore must have {missing}, got none ({remedy})", file=sys.stderr)
        return 1
    try:
        free_port = _free_port(port)
    except OSError as error:
        got = f"{port}: {error.strerror} (leave --port out for any)"
        return fail(f"port must be a free one, got {got}")
    for name in ("bokeh", "tornado", "panel"):
        logging.getLogger(name).setLevel(logging.ERROR)
    pages = Pages(current_limits())
    server = pn.io.server.get_server(
        pages.open,
        port=free_port,
        address=HOST,
        websocket_origin=[f"{HOST}:{free_port}", f"localhost:{free_port}"],
        title="longwave explore",
        show=False,
        start=False,
        unused_session_lifetime_milliseconds=CLOSED_PAGE_MS,
        check_unused_sessions_milliseconds=CLOSED_PAGE_MS // 2,
    )
    token = secrets.token_urlsafe(32)
    refuse_foreign_requests(server._tornado, free_port, token)
    address = f"http://{HOST}:{free_port}/?{TOKEN_KEY}={token}"
    return _serve(server, pages, address, browser, program)


def refuse_foreign_requests(application: Any, port: int, token: str) -> None:
    """Make the server answer 403 to requests for another host or without the token.

    Scripts and style sheets need no token, because they are the same for all. A path with a zero
    byte is refused as well, because Tornado fails on it.
    """
    from tornado.routing import Matcher, Rule
    from tornado.web import ErrorHandler

    hosts = (f"{HOST}:{port}", f"localhost:{port}")

    class Foreign(Matcher):
        """Tornado matcher of requests with another host, without the token or with a zero byte."""

        def match(self, request: Any) -> dict[str, Any] | None:
            token_given = request.query_arguments.get(TOKEN_KEY, [b""])[0]
            has_token = hmac.compare_digest(token_given, token.encode())
            public = request.path.startswith("/static/") or request.path == "/favicon.ico"
            allowed = request.host in hosts and (has_token or public) and "%00" not in request.path
            return None if allowed else {}

    router = application.default_router
    refusal = router.process_rule(Rule(Foreign(), ErrorHandler, {"status_code": 403}))
    router.rules.insert(0, refusal)


def _free_port(port: int) -> int:
    """Return ``port`` if it is free, or any free port if it is 0; raise OSError if it is taken."""
    with closing(socket.socket(socket.AF_INET, socket.SOCK_STREAM)) as trial_socket:
        trial_socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        trial_socket.bind((HOST, port))
        free_port: int = trial_socket.getsockname()[1]
        return free_port


def _serve(server: Any, pages: Pages, address: str, browser: bool, program: str) -> int:
    loop = server.io_loop
    server.start()
    count_notice()
    print(f"longwave explore: {address} (Ctrl-C ends it)", flush=True)
    with _open_browser(address) if browser else nullcontext():
        try:
            loop.start()
        except KeyboardInterrupt:
            for signal_number in ENDING:
                signal.signal(signal_number, signal.SIG_IGN)
        finally:
            server.stop()
            pages.close()
    return interrupted(program)


REDIRECT = """<!DOCTYPE html>
<html><head><meta charset="utf-8"><meta http-equiv="refresh" content="0; url={address}">
<title>longwave explore</title></head>
<body><p>The page is at <a href="{address}">{address}</a>.</p></body></html>
"""


@contextmanager
def _open_browser(address: str) -> Iterator[None]:
    """Open the browser at the address, by way of a file that only the user can read. The token must
    not be among the browser's arguments, which every user can read."""
    descriptor, name = tempfile.mkstemp(prefix="longwave-explore-", suffix=".html")
    try:
        with open(descriptor, "w", encoding="utf-8") as stream:
            stream.write(REDIRECT.format(address=escape(address)))
        page = Path(name).as_uri()
        threading.Thread(target=webbrowser.open, args=(page,), daemon=True).start()
        yield
    finally:
        Path(name).unlink(missing_ok=True)


def use_local_style_sheets(document: Any) -> None:
    """Make a page load its style sheets from this server, whenever its session is created.

    Panel sets this only when it writes the page. A session that is created again for an existing
    page would load them from another host.
    """
    document.template_variables["dist_url"] = LOCAL_STYLE_SHEETS


class Pages:
    """The open pages. Each gets a process once a browser shows it.

    The process of the first page is started in advance.
    """

    def __init__(self, limits: RequestLimits) -> None:
        from longwave.explore.exploration_run import Explorer

        self._limits = limits
        self._spare_explorers = [Explorer(limits)]
        self._spare_explorers[0].start()
        self._session_count = 0
        self._shown_pages: set[ExplorePage] = set()

    def open(self) -> Any:
        """Return a visitor's page, or a message if there are too many."""
        import panel as pn

        from longwave.explore.exploration_run import Explorer
        from longwave.explore.explore_page import POLL_MS, ExplorePage

        use_local_style_sheets(pn.state.curdoc)
        self._session_count += 1
        if self._session_count > MOST_SESSIONS:
            pn.state.on_session_destroyed(self._forget)
            return pn.pane.HTML(TOO_MANY)
        page = ExplorePage(Explorer(self._limits))

        def show_page() -> None:
            if len(self._shown_pages) >= MOST_PAGES:
                page.refuse_with(TOO_MANY)
                return
            self._shown_pages.add(page)
            if self._spare_explorers:
                page.explorer = self._spare_explorers.pop()
            page.start()

        def close_page(_: Any) -> None:
            self._session_count -= 1
            self._shown_pages.discard(page)
            page.explorer.close()

        pn.state.onload(show_page)
        pn.state.on_session_destroyed(close_page)
        pn.state.add_periodic_callback(page.poll, POLL_MS)
        return page.view()

    def _forget(self, _: Any) -> None:
        self._session_count -= 1

    def close(self) -> None:
        """Stop the processes of all pages."""
        for explorer in (*(page.explorer for page in self._shown_pages), *self._spare_explorers):
            explorer.close()
