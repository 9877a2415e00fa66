"""`longwave explore`: its error messages, its server, and the page itself in headless Chromium."""

import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from longwave.__main__ import main
from longwave.explore import explore_server
from longwave.explore.exploration import Scene, initial_choices
from longwave.explore.exploration_run import Explorer
from longwave.scenes.description.named_scenes import load_scene
from longwave.support.request_limits import RequestLimits

Output = pytest.CaptureFixture[str]

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
FLAGS = (
    "--headless",
    "--host-resolver-rules=MAP rebound.example 127.0.0.1",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
)

PATIENCE = 120_000
"""Milliseconds after which a page that does not answer is given up."""

explored = pytest.mark.skipif(
    CHROMIUM is None, reason="chromium is not installed (apt-get install chromium)"
)


def test_a_missing_extra_names_its_remedy(monkeypatch: pytest.MonkeyPatch, capsys: Output) -> None:
    monkeypatch.setitem(sys.modules, "panel", None)
    assert main(["explore", "--no-browser"]) == 1
    line = "error: longwave explore must have panel, got none (pip install 'longwave[explore]')\n"
    assert capsys.readouterr() == ("", line)


@pytest.mark.slow
def test_a_taken_port_is_a_one_line_error(capsys: Output) -> None:
    with closing(socket.create_server(("127.0.0.1", 0))) as taken:
        port = taken.getsockname()[1]
        assert main(["explore", "--no-browser", "--port", str(port)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert re.fullmatch(
        rf"error: port must be a free one, got {port}: .* \(leave --port out for any\)\n", err
    )


def test_there_is_no_way_to_serve_others(capsys: Output) -> None:
    assert explore_server.HOST == "127.0.0.1"
    assert main(["explore", "--address", "0.0.0.0"]) == 2
    assert main(["explore", "--port", "70000"]) == 2
    assert capsys.readouterr().out == ""


class IdleExplorer(Explorer):
    """An explorer that runs nothing."""

    def ask(self, scene: Scene) -> None:
        pass


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")  # panel 1.9 renames name to label
def test_style_sheets_come_from_this_server_also_before_the_page_is_written() -> None:
    """Catches: a browser that opened its session late and loaded them from another host."""
    from bokeh.document import Document
    from bokeh.models import ImportedStyleSheet
    from panel.io.state import set_curdoc

    from longwave.explore.explore_page import ExplorePage

    document = Document()
    with set_curdoc(document):
        explore_server.use_local_style_sheets(document)
        page = ExplorePage(IdleExplorer())
        page.view().server_doc(document)
        page.wave.value = "kink"
    sheets = {
        sheet.url for root in document.roots for sheet in root.select({"type": ImportedStyleSheet})
    }
    assert sheets
    assert all(sheet.startswith(explore_server.LOCAL_STYLE_SHEETS) for sheet in sheets)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")  # panel 1.9 renames name to label
def test_another_lattice_starts_with_its_own_choices() -> None:
    from longwave.explore.explore_page import ExplorePage

    page = ExplorePage(IdleExplorer())
    page.wave.value = "kdv_soliton"
    assert len(page.setting.options) > 1
    for setting in page.setting.options.values():
        page.setting.value = setting
        assert page.choices() == initial_choices("kdv_soliton", setting)


@dataclass
class Served:
    """A server in its own process."""

    process: subprocess.Popen[str]
    port: int
    token: str

    @property
    def root(self) -> str:
        return f"http://127.0.0.1:{self.port}/"

    @property
    def address(self) -> str:
        return f"{self.root}?token={self.token}"

    def answer(self, path: str, host: str, *lines: str) -> tuple[int, str]:
        """Return status and text of the answer to a hand-written request."""
        request = "\r\n".join((f"GET {path} HTTP/1.1", f"Host: {host}", *lines, "", ""))
        with closing(socket.create_connection(("127.0.0.1", self.port), timeout=600)) as line:
            line.sendall(request.encode())
            status = line.recv(20).split()[1]
            text = b""
            while status == b"200" and b"</html>" not in text:
                text += line.recv(2**16)
        return int(status), text.decode(errors="replace")

    def talk(self, path: str, host: str, origin: str) -> int:
        """Return the status of the answer to a websocket request."""
        _, page = self.answer(f"/?token={self.token}", f"127.0.0.1:{self.port}")
        token = re.search(r'"token":"([^"]+)"', page)
        assert token
        status, _ = self.answer(
            path, host, "Upgrade: websocket", "Connection: Upgrade", f"Origin: {origin}",
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==", "Sec-WebSocket-Version: 13",
            f"Sec-WebSocket-Protocol: bokeh, {token[1]}",
        )  # fmt: skip
        return status

    def runners(self) -> int:
        """Return the worker processes of the page."""
        children = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text()
        lines = [Path(f"/proc/{child}/cmdline").read_bytes() for child in children.split()]
        return sum(b"spawn_main" in line for line in lines)


@pytest.fixture(scope="module")
def served() -> Iterator[Served]:
    process = subprocess.Popen(
        [sys.executable, "-m", "longwave", "explore", "--no-browser"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        cwd=Path(__file__).parents[3],
    )  # fmt: skip
    try:
        assert process.stdout is not None
        line = process.stdout.readline()
        found = re.fullmatch(
            r"longwave explore: http://127\.0\.0\.1:(\d+)/\?token=([\w-]{43}) \(Ctrl-C ends it\)\n",
            line,
        )
        assert found, line
        yield Served(process, int(found[1]), found[2])
    finally:
        process.kill()
        process.communicate()


def listening(process: subprocess.Popen[str]) -> set[tuple[str, int]]:
    """Return the addresses and ports on which the process listens, as the system reports them."""
    inodes = set()
    for entry in Path(f"/proc/{process.pid}/fd").iterdir():
        if match := re.fullmatch(r"socket:\[(\d+)\]", os.readlink(entry)):
            inodes.add(match[1])
    found = set()
    for table in ("tcp", "tcp6"):
        for row in Path(f"/proc/{process.pid}/net/{table}").read_text().splitlines()[1:]:
            fields = row.split()
            if fields[3] == "0A" and fields[9] in inodes:
                address, port = fields[1].split(":")
                found.add((address, int(port, 16)))
    return found


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/net/tcp").exists(), reason="the system has no /proc")
def test_the_server_listens_on_the_loopback_alone(served: Served) -> None:
    assert listening(served.process) == {("0100007F", served.port)}


HERE, THERE = "127.0.0.1:{port}", "evil.example:{port}"
WITH, WITHOUT = "/?token={token}", "/?token=wrong"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("path", "host", "status"),
    [
        (WITH, HERE, 200),
        (WITH, "localhost:{port}", 200),
        (WITH, THERE, 403),
        (WITH, "127.0.0.1:80", 403),
        (WITHOUT, HERE, 403),
        ("/", HERE, 403),
        ("/autoload.js", HERE, 403),
        ("/metadata", HERE, 403),
        ("/static/nothing", THERE, 403),
        ("/static/extensions/panel/%00", HERE, 403),
        ("/static/nothing", HERE, 404),
    ],
)
def test_requests_for_another_host_or_without_the_token_are_refused(
    served: Served, path: str, host: str, status: int
) -> None:
    """A foreign host name may resolve to this machine; the browser then takes us for that host."""
    port, token = served.port, served.token
    found, _ = served.answer(path.format(token=token), host.format(port=port))
    assert found == status


@pytest.mark.slow
@pytest.mark.parametrize(
    ("query", "host", "origin", "status"),
    [
        (WITH, HERE, HERE, 101),
        (WITH, HERE, THERE, 403),
        (WITH, THERE, THERE, 403),
        (WITH, THERE, HERE, 403),
        (WITHOUT, HERE, HERE, 403),
        ("/", HERE, HERE, 403),
    ],
)
def test_the_websocket_checks_host_origin_and_token(
    served: Served, query: str, host: str, origin: str, status: int
) -> None:
    port, path = served.port, f"/ws{query[1:]}".format(token=served.token)
    assert served.talk(path, host.format(port=port), f"http://{origin.format(port=port)}") == status


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/net/tcp").exists(), reason="the system has no /proc")
def test_pages_that_no_browser_shows_start_no_processes(served: Served) -> None:
    """Only the first page's process exists, which is started in advance."""
    for _ in range(explore_server.MOST_PAGES + 2):
        status, _ = served.answer(f"/?token={served.token}", f"127.0.0.1:{served.port}")
        assert status == 200
    assert served.runners() <= 1


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")  # panel 1.9 renames name to label
def test_the_number_of_pages_and_sessions_is_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    import panel as pn
    from bokeh.document import Document
    from panel.io.state import set_curdoc

    from longwave.explore.explore_page import ExplorePage

    monkeypatch.setattr(explore_server, "MOST_PAGES", 1)
    monkeypatch.setattr(explore_server, "MOST_SESSIONS", 3)
    requests: list[Explorer] = []
    output: list[str] = []
    monkeypatch.setattr(ExplorePage, "refuse_with", lambda _, line: output.append(line))
    monkeypatch.setattr(Explorer, "start", lambda _: None)
    monkeypatch.setattr(Explorer, "submit", lambda one, _: requests.append(one))
    monkeypatch.setattr(pn.state, "add_periodic_callback", lambda *_: None)
    shown: list[Any] = []
    monkeypatch.setattr(pn.state, "onload", shown.append)
    pages, views = explore_server.Pages(RequestLimits(2e9, 10.0)), []
    for _ in range(4):
        with set_curdoc(Document()):
            views.append(pages.open())
    assert (len(shown), requests) == (3, [])
    for begin in shown:
        begin()
    assert len(requests) == 1
    assert output == 2 * [explore_server.TOO_MANY]
    assert isinstance(views[-1], pn.pane.HTML)
    pages.close()


@dataclass
class Opened:
    """A page in the browser, and every address that it requested."""

    page: Any
    requests: list[str]
    errors: list[str]

    def finished(self) -> None:
        """Wait until the submitted run has finished."""
        self.page.locator(".status.done").wait_for(timeout=PATIENCE)

    def largest(self) -> str:
        text: str = self.page.locator(".outcome .value").first.inner_text()
        return text

    def figure(self) -> bytes:
        """Return the profile's picture once two successive screenshots agree."""
        before = b""
        for _ in range(100):
            now: bytes = self.page.locator(".profile").screenshot()
            if now == before:
                return now
            before = now
            time.sleep(0.3)
        raise AssertionError("the picture does not come to rest")

    def changed_from(self, text: str) -> None:
        """Wait until the largest difference has changed."""
        for _ in range(PATIENCE // 100):
            if self.page.locator(".status.done").count() and self.largest() != text:
                return
            time.sleep(0.1)
        raise AssertionError(f"the outcome stays {text}")


@pytest.fixture(scope="module")
def opened(served: Served) -> Iterator[Opened]:
    from playwright.sync_api import sync_playwright

    with sync_playwright() as tool:
        browser = tool.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page = browser.new_page(viewport={"width": 1400, "height": 2200})
        found = Opened(page, [], [])
        page.on("request", lambda request: found.requests.append(request.url))
        page.on("pageerror", lambda error: found.errors.append(str(error)))
        page.on(
            "console", lambda message: message.type == "error" and found.errors.append(message.text)
        )
        page.goto(served.address, timeout=PATIENCE)
        found.finished()
        yield found
        browser.close()


@explored
@pytest.mark.slow
@pytest.mark.parametrize("which", ["host", "token"])
def test_a_browser_is_refused_by_another_name_or_without_the_token(
    which: str, opened: Opened, served: Served
) -> None:
    """A foreign host name resolves to this machine here."""
    page = opened.page.context.browser.new_page()
    there = f"http://rebound.example:{served.port}/?token={served.token}"
    answer = page.goto(there if which == "host" else served.root, timeout=PATIENCE)
    assert answer.status == 403
    page.close()


@explored
@pytest.mark.slow
def test_a_wave_is_chosen_and_a_slider_moved(opened: Opened) -> None:
    page = opened.page
    before, first = opened.largest(), opened.figure()
    page.locator(".choose-wave select").select_option(label="Sech soliton")
    opened.changed_from(before)
    after, second = opened.largest(), opened.figure()
    assert second != first
    page.locator(".slider-eps .noUi-handle").focus()
    for _ in range(20):
        page.keyboard.press("ArrowRight")
    opened.changed_from(after)
    assert opened.figure() != second
    eps = float(page.locator(".entry-eps input").input_value())
    assert eps > 0.1
    assert "eps = " in page.locator(".toml textarea").input_value()


@explored
@pytest.mark.slow
def test_an_inadmissible_choice_shows_the_librarys_message(opened: Opened) -> None:
    page = opened.page
    page.locator(".choose-wave select").select_option(label="Rogue wave on the cnoidal wave")
    page.wait_for_selector(".entry-k input", timeout=PATIENCE)
    opened.finished()
    box = page.locator(".entry-k input")
    for typed, line in (
        ("1.2", "k must satisfy 0 < k < 1, got 1.2 (k = 1 is the triple-pole soliton)"),
        ("<b>", "k: expected a number, a name or '(', got '<' (column 1)"),
    ):
        box.fill(typed)
        box.press("Enter")
        page.get_by_text(line, exact=True).wait_for(timeout=PATIENCE)
    assert "Traceback" not in page.content()
    box.fill("0.6")
    box.press("Enter")
    page.wait_for_selector(".refusal", state="detached", timeout=PATIENCE)
    opened.finished()


@explored
@pytest.mark.slow
def test_an_example_is_run_and_downloaded(opened: Opened, tmp_path: Path) -> None:
    page, before = opened.page, opened.largest()
    title = "KdV soliton on the Toda lattice"
    page.locator(".choose-example select").select_option(label=title)
    opened.changed_from(before)
    with page.expect_download(timeout=PATIENCE) as download:
        page.locator(".download a, .download button").first.click()
    path = tmp_path / "taken.toml"
    download.value.save_as(path)
    assert path.read_text(encoding="utf-8") == page.locator(".toml textarea").input_value()
    scene = load_scene(str(path))
    assert scene.title == title


@explored
@pytest.mark.slow
def test_on_a_phone_the_controls_are_a_drawer_and_nothing_is_wider_than_the_screen(
    opened: Opened,
) -> None:
    page = opened.page
    page.set_viewport_size({"width": 390, "height": 844})
    try:
        page.wait_for_function(
            "(({x, width}) => x == -390 && width == 390)"
            "(document.querySelector('#sidebar').getBoundingClientRect())",
            timeout=PATIENCE,
        )  # it slides
        for selector in ("html", "#main"):
            assert page.evaluate(f"document.querySelector('{selector}').scrollWidth") <= 390
        places = [page.locator(name).bounding_box() for name in ("#main", "#sidebar")]
        assert [place and (place["x"], place["width"]) for place in places] == [
            (0, 390),
            (-390, 390),
        ]
        page.locator("#sidebar-button").click()
        page.wait_for_function(
            "document.querySelector('#sidebar').getBoundingClientRect().x == 0", timeout=PATIENCE
        )
        assert page.locator(".choose-wave select").is_visible()
        page.locator("#sidebar-button").click()
    finally:
        page.set_viewport_size({"width": 1400, "height": 2200})


@explored
@pytest.mark.slow
def test_no_request_leaves_this_machine(opened: Opened, served: Served) -> None:
    outside = [
        address
        for address in opened.requests
        if not address.startswith((served.root, "data:", "blob:"))
    ]
    assert outside == []
    assert opened.errors == []


@pytest.mark.slow
def test_ctrl_c_ends_the_server_in_one_line(served: Served) -> None:
    """This must be the last test, because the server is gone afterwards."""
    begun = time.monotonic()
    served.process.send_signal(signal.SIGINT)
    out, err = served.process.communicate(timeout=600)
    taken = time.monotonic() - begun
    passing = ("Refusing websocket connection", "so far (Ctrl-C stops it)")
    output = [line for line in err.splitlines() if not any(text in line for text in passing)]
    assert (out, output) == ("", ["longwave explore: interrupted"])
    assert served.process.returncode == 130
    assert taken < 30.0, "main returns after 0.05 s, even with the machine overloaded six times"
