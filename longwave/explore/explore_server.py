"""``longwave explore``: the page is served to this machine alone until Ctrl-C."""

from __future__ import annotations

import logging
import signal
import socket
import sys
import threading
import webbrowser
from contextlib import closing
from typing import Any

from longwave.support.command_line import fail
from longwave.support.interruption import interrupted
from longwave.support.request_limits import RequestLimits, current_limits
from longwave.support.slow_work import count_notice

HOST = "127.0.0.1"
"""The loopback: nothing outside this machine reaches it."""

MOST_PAGES = 10
"""Pages that are open at a time: each has a process of its own."""

LEFT = 60_000
"""Milliseconds after which a page that was closed is forgotten, its process ended; a slow browser
has as long to come back for what it was promised."""

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
    return _serve(server, pages, f"http://{HOST}:{found}/", browser, program)


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
    if browser:
        threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()
    try:
        loop.start()
    except KeyboardInterrupt:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    finally:
        server.stop()
        pages.close()
    return interrupted(program)


def keep_style_sheets_here(document: Any) -> None:
    """Have a page's style sheets come from this server, whenever its session is made.

    Panel says so only when it writes the page; a session that is made again for a page that was
    written before would send the browser to another host.
    """
    document.template_variables["dist_url"] = LOCAL


class Pages:
    """The pages that are open, each with its process; the first one's is begun beforehand."""

    def __init__(self, limits: RequestLimits) -> None:
        from longwave.explore.exploration_run import Explorer

        self._limits = limits
        self._spare = [Explorer(limits)]
        self._spare[0].start()
        self._open: set[Explorer] = set()

    def open(self) -> Any:
        """A visitor's page, or a line that there are too many."""
        import panel as pn

        from longwave.explore.exploration_run import Explorer
        from longwave.explore.explore_page import LOOK, ExplorePage

        keep_style_sheets_here(pn.state.curdoc)
        if len(self._open) >= MOST_PAGES:
            return pn.pane.HTML(f"At most {MOST_PAGES} pages may be open: close one, and reload.")
        explorer = self._spare.pop() if self._spare else Explorer(self._limits)
        self._open.add(explorer)

        def leave(_: Any) -> None:
            self._open.discard(explorer)
            explorer.close()

        pn.state.on_session_destroyed(leave)
        page = ExplorePage(explorer)
        pn.state.add_periodic_callback(page.look, LOOK)
        return page.view()

    def close(self) -> None:
        """End the pages' processes."""
        for explorer in (*self._open, *self._spare):
            explorer.close()
