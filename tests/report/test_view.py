"""The page in a real browser: what it draws, and what it does when it is used."""

import io
import json

import numpy as np
import pytest
from PIL import Image

PLANE = (143, 179, 217)
SHARP = (216, 80, 63)
MARK = (217, 72, 15)


# The page as it was when it opened; to open it anew takes seconds without a graphics card.
RESET = """
document.querySelector('[data-preset=model]').click();
document.querySelector('[data-look=iso]').click();
const row = document.querySelector('#faces [aria-selected=true]'), set = (id, event, value) => {
  const control = document.getElementById(id);
  control.value = value;
  control.dispatchEvent(new Event(event));
};
row?.click();
set('divider', 'input', 0.5), set('range', 'input', 0), set('section-axis', 'change', '');
const first = document.querySelector('#faces th');
while (first.ariaSort !== 'ascending') first.firstElementChild.click();
"""


@pytest.fixture(scope="module")
def opened(chromium, report):
    chromium.window(1280, 800)
    chromium.scheme("light")
    chromium.open(report)
    chromium.wait("document.documentElement.dataset.places")
    return chromium


@pytest.fixture
def page(opened, chromium, report):
    chromium.run(f"{{{RESET}}}")
    yield chromium
    assert chromium.errors == []
    asked = [url for url in chromium.requests if not url.startswith("data:")]
    assert asked == [report.resolve().as_uri()]


def click(page, selector):
    page.run(f"document.querySelector({json.dumps(selector)}).click()")


def picture(page):
    """The pixels of the view, without what lies over it."""
    page.run("document.querySelectorAll('.tools, .layers, .bar').forEach(e => e.style.opacity = 0)")
    box = page.run("(b => [b.x, b.y, b.right, b.bottom])(view.getBoundingClientRect())")
    return np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGB").crop(box), int)[
        5:-5, 5:-5
    ]


def middle(pixels, size=20):
    h, w = pixels.shape[0] // 2, pixels.shape[1] // 2
    return pixels[h - size : h + size, w - size : w + size].reshape(-1, 3)


def share_like(pixels, colour, limit=0.10):
    """Share of pixels of a colour, whatever the light."""
    pixels = pixels.reshape(-1, 3)
    direction = np.array(colour) / np.linalg.norm(colour)
    length = np.linalg.norm(pixels, axis=1)
    off = np.linalg.norm(pixels / np.maximum(length, 1)[:, None] - direction, axis=1)
    return float(np.mean((off < limit) & (length > 60)))


def pressed(page):
    return page.run("document.querySelector('[data-preset][aria-pressed=true]')?.dataset.preset")


def test_draws_the_model_and_switches_it_off(page):
    assert pressed(page) == "model"
    click(page, "[data-look=z]")
    assert share_like(middle(picture(page)), PLANE, 0.05) == 1.0
    click(page, "[data-layer=model]")
    gone = picture(page)
    assert share_like(middle(gone), PLANE, 0.05) == 0.0
    # What is left are the edges and the corners, in ink.
    assert 0.001 < np.mean(gone.max(axis=2) < 60) < 0.05
    click(page, "[data-layer=sharp]")
    click(page, "[data-layer=corners]")
    assert np.mean(picture(page).max(axis=2) < 60) == 0.0
    assert pressed(page) is None


def test_the_cloud_has_the_colours_of_its_deviations(page):
    click(page, "[data-preset=deviation]")
    for look, blue_is_inside in (("x", True), ("z", False)):
        click(page, f"[data-look={look}]")
        pixels = middle(picture(page), 150)
        blue, red = pixels[:, 2] - pixels[:, 0] > 40, pixels[:, 0] - pixels[:, 2] > 40
        more, less = (blue, red) if blue_is_inside else (red, blue)
        assert more.mean() > 5 * less.mean()
        assert more.mean() > 0.02
    assert page.run("document.getElementById('ticks').innerText.split(/\\s+/)") == [
        "mm", "+0.3", "+0.15", "0", "\u22120.15", "\u22120.3",
    ]  # fmt: skip
    page.run("range.value = 1; range.dispatchEvent(new Event('input'))")
    assert "+3" in page.run("document.getElementById('ticks').innerText")


def test_sharp_patches_stand_along_the_edges(page):
    click(page, "[data-preset=patches]")
    click(page, "[data-look=z]")
    pixels = picture(page)
    assert share_like(middle(pixels, 60), SHARP) == 0.0
    # 28 of the 64 quads of a side touch an edge; the picture shows one side.
    red, flat = share_like(pixels, SHARP), share_like(pixels, (207, 214, 220), 0.03)
    assert red > 0.05
    assert share_like(middle(pixels, 100), SHARP, 0.2) < 0.05 < flat


def test_the_plain_surface_is_smaller_at_the_corners(page):
    click(page, "[data-look=z]")
    click(page, "[data-preset=wipe]")
    areas = []
    for place in (0, 1):
        page.run(f"divider.value = {place}; divider.dispatchEvent(new Event('input'))")
        picture(page)
        page.run("document.querySelectorAll('#divider, #sides').forEach(e => e.style.opacity = 0)")
        areas.append(np.mean(picture(page).std(axis=2) > 3))
    sharp, plain = areas
    assert 0.9 < plain / sharp < 0.985
    assert sharp > 0.2


def test_picking_a_face_selects_its_row_and_the_other_way_round(page):
    selected = (
        "[...document.querySelectorAll('#faces [aria-selected=true]')].map(r => r.dataset.face)"
    )
    x, y = page.run("(b => [b.x + b.width / 2, b.y + b.height / 2])(view.getBoundingClientRect())")
    page.settle()
    # From a corner +x looks to the right, -y to the left, and +z up.
    for right, down, face in ((0, -160, "5"), (150, 50, "1"), (-110, 70, "2"), (0, 395, None)):
        page.mouse(x + right, y + down)
        assert page.run(selected) == ([] if face is None else [face])
    click(page, "[data-look=z]")
    page.settle()
    page.mouse(x, y)
    assert page.run(selected) == ["5"]
    assert share_like(middle(picture(page)), MARK, 0.06) == 1.0
    click(page, "#faces [data-face='0']")
    assert page.run(selected) == ["0"]
    assert share_like(middle(picture(page)), MARK, 0.06) == 0.0
    click(page, "#faces [data-face='0']")
    assert page.run(selected) == []


def test_a_face_that_is_hidden_shines_through(page):
    click(page, "[data-look=z]")
    plain = middle(picture(page)).mean(axis=0)
    click(page, "#faces [data-face='4']")
    seen = middle(picture(page)).mean(axis=0)
    assert seen[0] - seen[2] > plain[0] - plain[2] + 60


def test_the_table_sorts_by_any_column(page):
    rows = "[...document.querySelectorAll('#faces tbody tr')].map(r => Number(r.dataset.face))"
    assert page.run(rows) == [0, 1, 2, 3, 4, 5]
    click(page, "#faces th:nth-child(10) button")
    assert page.run(rows)[-1] == 5  # the only face with a positive mean
    assert page.run("document.querySelector('#faces th:nth-child(10)').ariaSort") == "ascending"
    click(page, "#faces th:nth-child(10) button")
    assert page.run(rows)[0] == 5
    click(page, "#faces th:nth-child(1) button")
    assert page.run(rows) == [0, 1, 2, 3, 4, 5]


def test_keys_do_what_the_mouse_does(page):
    before = picture(page)
    page.run("view.focus()")
    page.key("ArrowLeft")
    turned = picture(page)
    assert np.mean(np.abs(turned - before).max(axis=2) > 30) > 0.01
    page.key("ArrowRight")
    np.testing.assert_allclose(picture(page), before, atol=12)
    page.run("document.querySelector('#faces tbody tr').focus()")
    page.key("ArrowDown")
    page.key("Enter")
    assert page.run("document.activeElement.dataset.face") == "1"
    assert page.run("document.activeElement.ariaSelected") == "true"
    page.key("Escape")
    assert page.run("document.activeElement.ariaSelected") == "false"
    unnamed = "[...document.querySelectorAll('button, input, select, canvas')].filter(e =>" \
        " !e.innerText.trim() && !e.ariaLabel && !e.closest('label')).length"  # fmt: skip
    assert page.run(unnamed) == 0


def test_a_warning_shows_its_place(page):
    style = page.run("document.querySelector('[data-place]').style.backgroundImage")
    assert style.startswith('url("data:image/png;base64,')
    whole = page.run("document.getElementById('scale').innerText")
    click(page, "[data-place]")
    assert share_like(middle(picture(page), 14), MARK, 0.06) > 0.1  # a ring round the middle
    assert page.run("document.getElementById('scale').innerText") != whole


def test_a_section_hides_what_lies_before_it(page):
    click(page, "[data-look=x]")
    page.run(
        "document.getElementById('section-axis').value = 'X';"
        "document.getElementById('section-axis').dispatchEvent(new Event('change'))"
    )
    click(page, "#faces [data-face='1']")  # the face towards the eye is cut away
    assert share_like(middle(picture(page)), MARK, 0.06) == 0.0


def test_follows_the_switch_of_colours(page):
    for theme, low, high in (("dark", 0, 80), ("light", 200, 255)):
        click(page, "#theme")
        assert page.run("document.documentElement.dataset.theme") == theme
        assert low < picture(page)[5, 5].mean() < high


# These open the page anew, so they come last.


def test_fits_a_phone_in_the_dark(page, report):
    page.window(390, 844, phone=True)
    page.scheme("dark")
    page.open(report)
    assert picture(page)[5, 5].mean() < 80
    assert page.run("document.documentElement.scrollWidth") <= 390
    assert share_like(middle(picture(page)), PLANE, 0.1) > 0.5
    assert page.run("document.querySelector('h1').getBoundingClientRect().bottom") < 844


def test_without_webgl_the_tables_remain(chromium, report):
    broken = "HTMLCanvasElement.prototype.getContext = () => null"
    added = chromium.call("Page.addScriptToEvaluateOnNewDocument", source=broken)
    try:
        chromium.call("Page.navigate", url=report.resolve().as_uri())
        chromium.wait("document.getElementById('notice')?.innerText.includes('no WebGL')")
        click(chromium, "#faces th:nth-child(1) button")
        first = chromium.run("document.querySelector('#faces tbody tr').dataset.face")
        assert first == "5"
    finally:
        chromium.call("Page.removeScriptToEvaluateOnNewDocument", **added)
