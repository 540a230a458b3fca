"""Chromium without a window, driven as a user would: mouse, keys, downloads.

It is told by the DevTools protocol through two pipes (``--remote-debugging-pipe``): JSON messages, each ended
by a zero byte. So no library is needed but the browser.
"""

from __future__ import annotations

import base64
import io
import json
import os
import select
import shutil
import signal
import time
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

__all__ = ["CHROMIUM", "Browser"]

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
"""The program, or None."""
_ON_THE_PROCESSOR = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
_PATIENCE = 60.0  # s, for one answer of a machine that is busy


class Browser:
    """One page in one browser; a context manager.

    Parameters
    ----------
    page : Path
        The HTML file that it opens.
    folder : Path
        For its profile, and for what it downloads.
    webgl : bool
        Whether it draws in three dimensions, on the processor.
    """

    def __init__(self, page: Path, folder: Path, *, webgl: bool = False) -> None:
        self.downloads = folder / "downloads"
        self.downloads.mkdir(parents=True)
        self._count = 0
        self._unread = b""
        self.events: list[dict[str, Any]] = []
        asked, self._asking = os.pipe()
        self._answers, answering = os.pipe()
        assert CHROMIUM is not None
        options = [
            "--headless",
            "--no-sandbox",
            "--no-first-run",
            *(_ON_THE_PROCESSOR if webgl else ("--disable-gpu", "--disable-3d-apis")),
            "--disable-dev-shm-usage",
            "--disable-extensions",
            "--force-device-scale-factor=1",
            "--window-size=1300,900",
            "--remote-debugging-pipe",
        ]
        self._log = open(folder / "chromium.log", "wb")  # noqa: SIM115
        self._process = os.posix_spawn(
            CHROMIUM,
            [CHROMIUM, *options, f"--user-data-dir={folder / 'profile'}", "about:blank"],
            {**os.environ, "HOME": str(folder)},
            file_actions=[
                # Above 9 first: what a pipe has may be 3 or 4.
                (os.POSIX_SPAWN_DUP2, asked, 103),
                (os.POSIX_SPAWN_DUP2, answering, 104),
                (os.POSIX_SPAWN_DUP2, 103, 3),
                (os.POSIX_SPAWN_DUP2, 104, 4),
                (os.POSIX_SPAWN_DUP2, self._log.fileno(), 1),
                (os.POSIX_SPAWN_DUP2, self._log.fileno(), 2),
            ],
            setpgroup=0,
        )
        os.close(asked)
        os.close(answering)
        target = self._tell("Target.createTarget", url="about:blank")["targetId"]
        self._session = self._tell("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        self._tell("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(self.downloads))
        for domain in ("Page", "Runtime"):
            self.tell(f"{domain}.enable")
        self.tell("Page.navigate", url=page.resolve().as_uri())
        self._until(lambda: self.value("document.readyState") == "complete", "the page is there")

    def __enter__(self) -> Browser:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        os.killpg(self._process, signal.SIGKILL)
        os.waitpid(self._process, 0)
        os.close(self._asking)
        os.close(self._answers)
        self._log.close()

    # ---- What a user does

    def drag(self, *places: tuple[float, float]) -> None:
        """Press the mouse at the first of these places of the window, move it to each, release it."""
        for kind, (x, y) in (
            ("mouseMoved", places[0]),
            ("mousePressed", places[0]),
            *(("mouseMoved", place) for place in places[1:]),
            ("mouseReleased", places[-1]),
        ):
            held = {"mousePressed": 1, "mouseReleased": 0}.get(kind, int(places[0] != (x, y)))
            button = "none" if kind == "mouseMoved" and not held else "left"
            self.tell(
                "Input.dispatchMouseEvent", type=kind, x=x, y=y, button=button, buttons=held, clickCount=1
            )

    def click(self, selector: str) -> None:
        """The middle of what a CSS selector finds, after scrolling to it."""
        self.drag(self.place(selector))

    def place(self, selector: str) -> tuple[float, float]:
        """The middle of what a CSS selector finds, in the window."""
        left, top, width, height = self.box(selector)
        return left + width / 2, top + height / 2

    def box(self, selector: str) -> tuple[float, float, float, float]:
        """Left, top, width, height in the window of what a CSS selector finds, after scrolling to it."""
        name = json.dumps(selector)
        found = self.value(
            f"(() => {{ const one = document.querySelector({name}); one.scrollIntoView({{block: 'nearest'}});"
            "const { left, top, width, height } = one.getBoundingClientRect();"
            "return [left, top, width, height]; })()"
        )
        return found[0], found[1], found[2], found[3]

    def key(self, key: str, code: int, *, control: bool = False) -> None:
        """A key that writes nothing, by its name and its number."""
        for kind in ("rawKeyDown", "keyUp"):
            self.tell(
                "Input.dispatchKeyEvent",
                type=kind,
                key=key,
                windowsVirtualKeyCode=code,
                modifiers=2 if control else 0,
            )

    def type(self, text: str) -> None:
        """Text, where the keyboard's focus is."""
        self.tell("Input.insertText", text=text)

    def downloaded(self, name: str) -> Path:
        """A file of this name, once it is whole."""
        path = self.downloads / name
        self._until(path.exists, f"{name} is downloaded")
        return path

    # ---- What is looked at

    def value(self, expression: str) -> Any:
        """Of a JavaScript expression."""
        found = self.tell("Runtime.evaluate", expression=expression, returnByValue=True)
        assert "exceptionDetails" not in found, found["exceptionDetails"]
        return found["result"].get("value")

    def picture(self, selector: str) -> NDArray[np.uint8]:
        """(h, w, 3) what the window shows of what a CSS selector finds, after scrolling to it."""
        left, top, width, height = self.box(selector)
        clip = {"x": left, "y": top, "width": width, "height": height, "scale": 1}
        clip["x"] += self.value("scrollX")
        clip["y"] += self.value("scrollY")
        data = self.tell("Page.captureScreenshot", format="png", clip=clip)["data"]
        with Image.open(io.BytesIO(base64.b64decode(data))) as image:
            return np.asarray(image.convert("RGB"))

    def faults(self) -> list[str]:
        """Exceptions that the page has thrown, and what it wrote to the console."""
        kinds = ("Runtime.exceptionThrown", "Runtime.consoleAPICalled")
        return [json.dumps(event["params"]) for event in self.events if event["method"] in kinds]

    # ---- The protocol

    def tell(self, method: str, **parameters: Any) -> dict[str, Any]:
        """The answer of the page to a message."""
        return self._tell(method, self._session, **parameters)

    def _tell(self, method: str, session: str | None = None, /, **parameters: Any) -> dict[str, Any]:
        self._count += 1
        message = {"id": self._count, "method": method, "params": parameters}
        message |= {"sessionId": session} if session else {}
        os.write(self._asking, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next()
            if answer.get("id") != self._count:
                self.events.append(answer)
                continue
            assert "error" not in answer, (method, answer["error"])
            result: dict[str, Any] = answer["result"]
            return result

    def _next(self) -> dict[str, Any]:
        end = time.monotonic() + _PATIENCE
        while b"\0" not in self._unread:
            ready, _, _ = select.select([self._answers], [], [], max(end - time.monotonic(), 0))
            part = os.read(self._answers, 1 << 16) if ready else b""
            assert part, (
                "Chromium does not answer: " + Path(self._log.name).read_text(errors="replace")[-500:]
            )
            self._unread += part
        text, _, self._unread = self._unread.partition(b"\0")
        found: dict[str, Any] = json.loads(text)
        return found

    def _until(self, holds: Any, what: str) -> None:
        end = time.monotonic() + _PATIENCE
        while not holds():
            assert time.monotonic() < end, f"not in {_PATIENCE:g} s: {what}"
            time.sleep(0.05)
