"""`longwave explore`: its refusals, its server, and the page itself in headless Chromium."""

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
from longwave.explore.exploration import Scene, first_choices
from longwave.explore.exploration_run import Explorer
from longwave.scenes.named_scenes import load_scene

Output = pytest.CaptureFixture[str]

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
FLAGS = (
    "--headless",
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


def test_a_missing_extra_is_told_with_its_remedy(
    monkeypatch: pytest.MonkeyPatch, capsys: Output
) -> None:
    monkeypatch.setitem(sys.modules, "panel", None)
    assert main(["explore", "--no-browser"]) == 1
    line = "error: longwave explore must have panel, got none (pip install 'longwave[explore]')\n"
    assert capsys.readouterr() == ("", line)


def test_a_port_that_is_taken_is_told_in_one_line(capsys: Output) -> None:
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
    """One that runs nothing."""

    def ask(self, scene: Scene) -> None:
        pass


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")  # panel 1.9 renames name to label
def test_style_sheets_come_from_this_server_also_before_the_page_is_written() -> None:
    """A browser that came late for its session was sent to another host."""
    from bokeh.document import Document
    from bokeh.models import ImportedStyleSheet
    from panel.io.state import set_curdoc

    from longwave.explore.explore_page import ExplorePage

    document = Document()
    with set_curdoc(document):
        explore_server.keep_style_sheets_here(document)
        page = ExplorePage(IdleExplorer())
        page.view().server_doc(document)
        page.wave.value = "kink"
    sheets = {
        sheet.url for root in document.roots for sheet in root.select({"type": ImportedStyleSheet})
    }
    assert sheets
    assert all(sheet.startswith(explore_server.LOCAL) for sheet in sheets)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")  # panel 1.9 renames name to label
def test_another_lattice_is_begun_with_its_own_choices() -> None:
    from longwave.explore.explore_page import ExplorePage

    page = ExplorePage(IdleExplorer())
    page.wave.value = "kdv_soliton"
    assert len(page.setting.options) > 1
    for setting in page.setting.options.values():
        page.setting.value = setting
        assert page.choices() == first_choices("kdv_soliton", setting)


@dataclass
class Served:
    """A server in a process of its own."""

    process: subprocess.Popen[str]
    port: int

    @property
    def address(self) -> str:
        return f"http://127.0.0.1:{self.port}/"


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
            r"longwave explore: http://127\.0\.0\.1:(\d+)/ \(Ctrl-C ends it\)\n", line
        )
        assert found, line
        yield Served(process, int(found[1]))
    finally:
        process.kill()
        process.communicate()


def listening(process: subprocess.Popen[str]) -> set[tuple[str, int]]:
    """The addresses and ports on which the process listens, as the system has them."""
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


@pytest.mark.slow
@pytest.mark.parametrize(("origin", "status"), [("127.0.0.1", 101), ("evil.example", 403)])
def test_a_page_of_another_host_may_not_talk_to_the_server(
    served: Served, origin: str, status: int
) -> None:
    from urllib.request import urlopen

    with urlopen(served.address, timeout=600) as answer:
        token = re.search(r'"token":"([^"]+)"', answer.read().decode())
    assert token
    request = (
        f"GET /ws HTTP/1.1\r\nHost: 127.0.0.1:{served.port}\r\nUpgrade: websocket\r\n"
        f"Connection: Upgrade\r\nOrigin: http://{origin}:{served.port}\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n"
        f"Sec-WebSocket-Protocol: bokeh, {token[1]}\r\n\r\n"
    )
    with closing(socket.create_connection(("127.0.0.1", served.port), timeout=600)) as line:
        line.sendall(request.encode())
        assert line.recv(200).split()[1] == str(status).encode()


@dataclass
class Opened:
    """A page in the browser, and every address that it asked for."""

    page: Any
    asked: list[str]
    errors: list[str]

    def finished(self) -> None:
        """Wait until a run that was asked for has come to its end."""
        self.page.locator(".status.done").wait_for(timeout=PATIENCE)

    def largest(self) -> str:
        text: str = self.page.locator(".outcome .value").first.inner_text()
        return text

    def figure(self) -> bytes:
        """The picture of lattice and wave at one time, once two looks at it are the same."""
        before = b""
        for _ in range(100):
            now: bytes = self.page.locator(".profile").screenshot()
            if now == before:
                return now
            before = now
            time.sleep(0.3)
        raise AssertionError("the picture does not come to rest")

    def changed_from(self, text: str) -> None:
        """Wait until the largest difference is another."""
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
        page.on("request", lambda request: found.asked.append(request.url))
        page.on("pageerror", lambda error: found.errors.append(str(error)))
        page.on("console", lambda said: said.type == "error" and found.errors.append(said.text))
        page.goto(served.address, timeout=PATIENCE)
        found.finished()
        yield found
        browser.close()


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
def test_what_is_not_admitted_is_told_in_the_librarys_line(opened: Opened) -> None:
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
def test_a_ready_scene_is_run_and_taken_away(opened: Opened, tmp_path: Path) -> None:
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
        for selector in ("html", "#main"):
            assert page.evaluate(f"document.querySelector('{selector}').scrollWidth") <= 390
        places = [page.locator(name).bounding_box() for name in ("#main", "#sidebar")]
        assert [place and (place["x"], place["width"]) for place in places] == [
            (0, 390),
            (-390, 390),
        ]
        page.locator("#sidebar-button").click()
        page.wait_for_function("document.querySelector('#sidebar').getBoundingClientRect().x == 0")
        assert page.locator(".choose-wave select").is_visible()
        page.locator("#sidebar-button").click()
    finally:
        page.set_viewport_size({"width": 1400, "height": 2200})


@explored
@pytest.mark.slow
def test_no_request_leaves_this_machine(opened: Opened, served: Served) -> None:
    outside = [
        address
        for address in opened.asked
        if not address.startswith((served.address, "data:", "blob:"))
    ]
    assert outside == []
    assert opened.errors == []


@pytest.mark.slow
def test_ctrl_c_ends_the_server_in_one_line(served: Served) -> None:
    """The last test: the server is gone afterwards."""
    begun = time.monotonic()
    served.process.send_signal(signal.SIGINT)
    out, err = served.process.communicate(timeout=600)
    taken = time.monotonic() - begun
    passing = ("Refusing websocket connection", "so far (Ctrl-C stops it)")
    told = [line for line in err.splitlines() if not any(text in line for text in passing)]
    assert (out, told) == ("", ["longwave explore: interrupted"])
    assert served.process.returncode == 130
    assert taken < 30.0, "main returns after 0.05 s, even with the machine overloaded six times"
