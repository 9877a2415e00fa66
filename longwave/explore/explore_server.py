"""``longwave explore``: the page is served to its user alone until Ctrl-C.

A page of another host may send requests here too, under a name of its own that it has lead to this
machine, and so may other users of the machine. So a request is answered only if it names this
server as its host and knows the token in the address that was printed; the page's websocket has the
token from that address as well, and beside it the origin is asked for.
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
"""The loopback: nothing outside this machine reaches it."""

MOST_PAGES, MOST_SESSIONS = 10, 50
"""Pages that browsers show at a time, each with a process of its own; and with those that are asked
for and not yet shown, or closed and not yet forgotten."""

TOO_MANY = f"at most {MOST_PAGES} pages may be open: close one, and reload"

LEFT = 60_000
"""Milliseconds after which a page that was closed is forgotten, its process ended; a slow browser
has as long to come back for what it was promised."""

TOKEN = "token"
"""The word of the address behind which its token stands."""

LOCAL = "static/extensions/panel/"
"""Where this server has its style sheets."""


def explore(port: int, browser: bool, program: str) -> int:
    """Serve the page until Ctrl-C, which ``program`` tells; return the exit status.

    130 after Ctrl-C, 2 for a port that is taken, 1 if what the page takes is not installed.
    ``port`` 0 is any free one.
    """
    try:
        import panel as pn
        from latex2mathml import converter  # noqa: F401  (asked for with the page)
    except ImportError as error:
        missing = (error.name or "panel").partition(".")[0]
        print(
            f"error: longwave explore must have {missing}, got none "
            "(pip install 'longwave[explore]')",
            file=sys.stderr,
        )
        return 1
    try:
        found = _free_port(port)
    except OSError as error:
        return fail(
            f"port must be a free one, got {port}: {error.strerror} (leave --port out for any)"
        )
    for name in ("bokeh", "tornado", "panel"):
        logging.getLogger(name).setLevel(logging.ERROR)
    pages = Pages(current_limits())
    server = pn.io.server.get_server(
        pages.open,
        port=found,
        address=HOST,
        websocket_origin=[f"{HOST}:{found}", f"localhost:{found}"],
        title="longwave explore",
        show=False,
        start=False,
        unused_session_lifetime_milliseconds=LEFT,
        check_unused_sessions_milliseconds=LEFT // 2,
    )
    token = secrets.token_urlsafe(32)
    refuse_others(server._tornado, found, token)
    return _serve(server, pages, f"http://{HOST}:{found}/?{TOKEN}={token}", browser, program)


def refuse_others(application: Any, port: int, token: str) -> None:
    """Have the server answer 403 to whoever names another host or has not the token.

    A path with a zero byte, which no file's name has, is refused as well: Tornado fails over it.
    What pages are made of needs none: scripts and style sheets are the same for all.
    """
    from tornado.routing import Matcher, Rule
    from tornado.web import ErrorHandler

    hosts = (f"{HOST}:{port}", f"localhost:{port}")

    class Others(Matcher):
        """Requests that are to be refused."""

        def match(self, request: Any) -> dict[str, Any] | None:
            given = request.query_arguments.get(TOKEN, [b""])[0]
            known = hmac.compare_digest(given, token.encode())
            public = request.path.startswith("/static/") or request.path == "/favicon.ico"
            allowed = request.host in hosts and (known or public) and "%00" not in request.path
            return None if allowed else {}

    router = application.default_router
    refusal = router.process_rule(Rule(Others(), ErrorHandler, {"status_code": 403}))
    router.rules.insert(0, refusal)


def _free_port(port: int) -> int:
    """The port itself if it is free, any free one for 0; OSError if it is taken."""
    with closing(socket.socket(socket.AF_INET, socket.SOCK_STREAM)) as trial:
        trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        trial.bind((HOST, port))
        found: int = trial.getsockname()[1]
        return found


def _serve(server: Any, pages: Pages, address: str, browser: bool, program: str) -> int:
    loop = server.io_loop
    server.start()
    count_notice()
    print(f"longwave explore: {address} (Ctrl-C ends it)", flush=True)
    with _shown(address) if browser else nullcontext():
        try:
            loop.start()
        except KeyboardInterrupt:
            for number in ENDING:
                signal.signal(number, signal.SIG_IGN)
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
def _shown(address: str) -> Iterator[None]:
    """Open the browser at the address, which stands in a file that the user alone may read.

    The browser's arguments are everybody's to read, and in them would be the token.
    """
    number, name = tempfile.mkstemp(prefix="longwave-explore-", suffix=".html")
    try:
        with open(number, "w", encoding="utf-8") as stream:
            stream.write(REDIRECT.format(address=escape(address)))
        page = Path(name).as_uri()
        threading.Thread(target=webbrowser.open, args=(page,), daemon=True).start()
        yield
    finally:
        Path(name).unlink(missing_ok=True)


def keep_style_sheets_here(document: Any) -> None:
    """Have a page's style sheets come from this server, whenever its session is made.

    Panel says so only when it writes the page; a session that is made again for a page that was
    written before would send the browser to another host.
    """
    document.template_variables["dist_url"] = LOCAL


class Pages:
    """The pages that are open; each has a process from when a browser has it and talks to it.

    The first one's is begun beforehand.
    """

    def __init__(self, limits: RequestLimits) -> None:
        from longwave.explore.exploration_run import Explorer

        self._limits = limits
        self._spare = [Explorer(limits)]
        self._spare[0].start()
        self._asked = 0
        self._shown: set[ExplorePage] = set()

    def open(self) -> Any:
        """A visitor's page, or a line that there are too many."""
        import panel as pn

        from longwave.explore.exploration_run import Explorer
        from longwave.explore.explore_page import LOOK, ExplorePage

        keep_style_sheets_here(pn.state.curdoc)
        self._asked += 1
        if self._asked > MOST_SESSIONS:
            pn.state.on_session_destroyed(self._forget)
            return pn.pane.HTML(TOO_MANY)
        page = ExplorePage(Explorer(self._limits))

        def begin() -> None:
            if len(self._shown) >= MOST_PAGES:
                page.turn_away(TOO_MANY)
                return
            self._shown.add(page)
            if self._spare:
                page.explorer = self._spare.pop()
            page.begin()

        def leave(_: Any) -> None:
            self._asked -= 1
            self._shown.discard(page)
            page.explorer.close()

        pn.state.onload(begin)
        pn.state.on_session_destroyed(leave)
        pn.state.add_periodic_callback(page.look, LOOK)
        return page.view()

    def _forget(self, _: Any) -> None:
        self._asked -= 1

    def close(self) -> None:
        """End the pages' processes."""
        for explorer in (*(page.explorer for page in self._shown), *self._spare):
            explorer.close()
