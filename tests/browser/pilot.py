"""A hand and an eye on one page of the real app in a real Chromium."""

from __future__ import annotations

import io
import os
import re
import shutil
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import Browser, Download, Locator, Page

FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
READY = """(names) => { const m = window.__viserMutable, t = window.__viserSceneTree;
  if (!m || !m.scene || !m.camera || !m.cameraControl || !t || !window.rg || !window.rg.state.fitted) return false;
  const r = m.canvas.getBoundingClientRect();   // both panels are docked, and the map fitted to what they leave
  if (r.width > innerWidth - 360 || (!window.rg.state.touched && window.rg.state.fitted !== `${r.width} x ${r.height}`))
    return false;
  const nodes = t.getState(); return names.every(n => nodes[n] !== undefined && m.nodeRefFromName[n]); }"""
FRAMES = """(n) => new Promise(r => { window.__viserMutable.requestRender();
  const f = k => k <= 0 ? r() : requestAnimationFrame(() => f(k - 1)); f(n); })"""
ON_SCREEN = """(p) => { const m = window.__viserMutable, cam = m.camera, root = m.nodeRefFromName[''];
  cam.updateMatrixWorld(); root.updateMatrixWorld();
  const V = cam.position.constructor, v = new V(...p).applyMatrix4(root.matrixWorld).project(cam);
  const r = m.canvas.getBoundingClientRect();
  return [r.left + (v.x + 1) / 2 * r.width, r.top + (1 - v.y) / 2 * r.height]; }"""


def chromium() -> str:
    """The system's Chromium, or the one that the variable CHROMIUM names."""
    named = os.environ.get("CHROMIUM")
    for name in (named,) if named else ("chromium", "chromium-browser", "google-chrome", "chrome"):
        if found := shutil.which(name):
            return found
    wanted = f"CHROMIUM={named} is not there" if named else "no Chromium on this machine"
    raise RuntimeError(f"{wanted}: install it (Debian: apt-get install chromium), or set CHROMIUM=/path/to/chromium")


class Pilot:
    """One page, opened by the link that the app prints."""

    def __init__(
        self,
        browser: Browser,
        url: str,
        nodes: tuple[str, ...] = ("/lines/lines",),
        size: tuple[int, int] = (1180, 760),
    ) -> None:
        self.context = browser.new_context(viewport={"width": size[0], "height": size[1]}, accept_downloads=True)
        self.page: Page = self.context.new_page()
        self.page.set_default_timeout(15_000)
        self.errors: list[str] = []
        self.page.on("pageerror", lambda e: self.errors.append(str(e)))
        self.page.goto(url)
        self.wait_nodes(*nodes)

    def close(self) -> None:
        self.context.close()

    def wait_nodes(self, *nodes: str, timeout: float = 30_000) -> None:
        self.page.wait_for_function(READY, arg=list(nodes), timeout=timeout)
        self.frames(3)

    def frames(self, n: int = 2) -> None:
        self.page.evaluate(FRAMES, n)

    # ---- the map ----------------------------------------------------------------------------------

    def at(self, x: float, y: float, z: float = 0.0) -> tuple[float, float]:
        """Pixel of the page where a point of the map is."""
        px, py = self.page.evaluate(ON_SCREEN, [float(x), float(y), float(z)])
        return px, py

    def click(self, x: float, y: float, z: float = 0.0, shift: bool = False) -> None:
        """Click the picture at a point of the map."""
        if shift:
            self.page.keyboard.down("Shift")
        self.page.mouse.move(*self.at(x, y, z))
        self.frames(2)  # the page must see the pointer there before the button goes down
        self.page.mouse.down()
        self.page.mouse.up()
        if shift:
            self.page.keyboard.up("Shift")

    def drag(self, a: tuple[float, float], b: tuple[float, float], steps: int = 8) -> None:
        """Drag from one pixel of the page to another."""
        self.page.mouse.move(*a)
        self.frames(2)
        self.page.mouse.down()
        for n in range(1, steps + 1):
            self.page.mouse.move(a[0] + (b[0] - a[0]) * n / steps, a[1] + (b[1] - a[1]) * n / steps)
            self.frames(1)
        self.page.mouse.up()

    def key(self, keys: str) -> None:
        """Press a key while no field has the focus."""
        self.page.evaluate("document.activeElement && document.activeElement.blur()")
        self.page.keyboard.press(keys)

    def picture(self) -> np.ndarray:
        """(H, W, 3) uint8 of what is on the canvas."""
        box = self.page.evaluate("(() => { const r = window.__viserMutable.canvas.getBoundingClientRect();"
                                 " return {x: r.x, y: r.y, width: r.width, height: r.height}; })()")  # fmt: skip
        return np.asarray(Image.open(io.BytesIO(self.page.screenshot(clip=box))).convert("RGB"))

    def canvas_box(self) -> tuple[float, float, float, float]:
        """Left, top, right, bottom of the picture on the page [px]."""
        r = self.page.evaluate("(() => { const r = window.__viserMutable.canvas.getBoundingClientRect();"
                               " return [r.left, r.top, r.right, r.bottom]; })()")  # fmt: skip
        return r[0], r[1], r[2], r[3]

    def visible(self, node: str) -> bool:
        return bool(self.page.evaluate("(n) => window.__viserSceneTree.getState()[n]?.effectiveVisibility", node))

    def shot(self, name: str) -> None:
        """Keep a picture of the page in the folder that RGVIZ_SHOTS names, if it does."""
        if folder := os.environ.get("RGVIZ_SHOTS"):
            Path(folder).mkdir(parents=True, exist_ok=True)
            self.frames(3)
            self.page.wait_for_timeout(300)
            self.page.screenshot(path=str(Path(folder) / f"{name}.png"))

    # ---- the panels -------------------------------------------------------------------------------

    def see(self, text: str | re.Pattern[str], timeout: float = 15_000) -> Locator:
        """Wait until a text is on the page."""
        found = self.page.get_by_text(text).first
        found.wait_for(timeout=timeout)
        return found

    def until(self, true: Callable[[], bool], timeout: float = 15_000) -> None:
        """Wait until something is so in the app, while the page goes on."""
        end = time.monotonic() + timeout / 1000
        while not true():
            assert time.monotonic() < end, "it never came to pass"
            self.page.wait_for_timeout(20)

    def gone(self, text: str | re.Pattern[str]) -> None:
        self.page.wait_for_function("(t) => !document.body.innerText.includes(t)", arg=text)

    def button(self, name: str | re.Pattern[str]) -> Locator:
        return self.page.get_by_role("button", name=name)

    def field(self, label: str) -> Locator:
        """The input beside a label (viser does not tie the two together)."""
        return self.page.locator(
            f'xpath=//label[normalize-space(.)="{label}"]/ancestor::*[.//input][1]//input[not(@type="hidden")]'
        ).first

    def type_into(self, label: str, text: str) -> None:
        self.field(label).fill(text)
        self.page.keyboard.press("Enter")

    def choose(self, label: str, option: str) -> None:
        self.field(label).click()
        self.page.get_by_role("option", name=option, exact=True).click()

    def layer(self, title: str) -> Locator:
        return self.page.get_by_label(title, exact=True)

    def download(self, ending: str) -> Download:
        with self.page.expect_download() as info:
            self.page.get_by_role("link", name=ending, exact=True).click()
        return info.value
