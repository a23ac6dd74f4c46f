"""Barriers of a page in a browser, as WCAG 2 (level AA) has them: contrast, names, table headers,
targets, reflow.
"""

from __future__ import annotations

from playwright.sync_api import Page

LEAST_CONTRAST = 4.5
"""Least ratio of the luminances of a text and its ground (WCAG 1.4.3)."""
LEAST_TARGET = 24
"""Least width and height of what is pressed, in pixels (WCAG 2.5.8)."""
KEYS = r"\b[A-Za-z]\w*_(?:deg|mm|kg|rpm|N|Nm|m_s|N_m)\b"
"""Keys of files, which a page replaces by names."""

_SCRIPT = """([least, target, keys]) => {
  const found = [];
  const seen = (part) => part.checkVisibility({ checkVisibilityCSS: true, contentVisibilityAuto: true })
    && part.getBoundingClientRect().width > 1 && part.getBoundingClientRect().height > 1;
  const channels = (colour) => colour.match(/[\\d.]+/g).map(Number);
  const luminance = (colour) => channels(colour).slice(0, 3).map((value) => value / 255)
    .map((value) => (value <= 0.03928 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4))
    .reduce((sum, value, k) => sum + value * [0.2126, 0.7152, 0.0722][k], 0);
  const ground = (part) => {
    for (let box = part; box; box = box.parentElement) {
      const colour = getComputedStyle(box).backgroundColor;
      if ((channels(colour)[3] ?? 1) > 0) return colour;
    }
    return matchMedia("(prefers-color-scheme: dark)").matches ? "rgb(18, 18, 18)" : "rgb(255, 255, 255)";
  };
  const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (texts.nextNode()) {
    const text = texts.currentNode.textContent.trim(), part = texts.currentNode.parentElement;
    if (!text || part.closest("script, style, option, title, [disabled]") || !seen(part)) continue;
    const style = getComputedStyle(part);
    const levels = [luminance(part.closest("svg") ? style.fill : style.color), luminance(ground(part))];
    levels.sort((a, b) => b - a);
    const contrast = (levels[0] + 0.05) / (levels[1] + 0.05);
    if (contrast < least) found.push(`contrast ${contrast.toFixed(2)}: ${text.slice(0, 40)}`);
    const isKey = !part.closest("pre, code, small") && new RegExp(keys).test(text);
    if (isKey) found.push(`key: ${text.slice(0, 60)}`);
  }
  const name = (part) => [part.getAttribute("aria-label"), part.labels?.[0]?.textContent, part.textContent, part.title]
    .map((text) => (text ?? "").trim()).find((text) => text) ?? "";
  for (const part of document.querySelectorAll("button, input, select, textarea, a[href], summary")) {
    if (!seen(part)) continue;
    if (!name(part)) found.push(`name: ${part.outerHTML.slice(0, 80)}`);
    if (new RegExp(keys).test(part.getAttribute("aria-label") ?? "")) found.push(`key: ${name(part)}`);
    const box = (part.closest("label") ?? part).getBoundingClientRect();
    const inline = part.matches("p *, li *, td *, th *");
    const size = [box.width, box.height].map(Math.round);
    if (Math.min(...size) < target && !inline) found.push(`target ${size.join(" x ")}: ${name(part).slice(0, 40)}`);
  }
  for (const table of document.querySelectorAll("table")) {
    if (!seen(table)) continue;
    const heads = Array.from(table.querySelectorAll("th"));
    const rows = heads.some((head) => head.scope === "row");
    const loose = heads.some((head) => !["col", "row"].includes(head.scope));
    if (!rows || loose) found.push(`table: ${table.innerText.slice(0, 40)}`);
  }
  for (const picture of document.querySelectorAll("svg[role=img]")) {
    if (seen(picture) && !picture.getAttribute("aria-label")) found.push("name: a picture");
  }
  const aside = document.documentElement.scrollWidth - innerWidth;
  if (aside > 0) found.push(`scrolls sideways by ${aside} pixels`);
  if (!document.documentElement.lang) found.push("language");
  return found;
}"""


def list_barriers(page: Page) -> list[str]:
    """Return the barriers of a page as it is displayed, each with what it concerns."""
    barriers: list[str] = page.evaluate(_SCRIPT, [LEAST_CONTRAST, LEAST_TARGET, KEYS])
    return barriers
