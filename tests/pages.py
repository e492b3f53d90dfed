"""Looks at every page of results folders in headless Chromium: 1400 and 420 px wide, light and dark.

usage: python3 tests/pages.py FOLDER ...    (folders with a report.html; exit 1 when something is found)
Needs chromium (Debian package `chromium`). Exit 77 says that it is missing.

Found are: errors of the page's script, a figure that cannot be saved as PNG, text that lies on other text of the same figure, a page wider than its window, figures
with an axis that names no unit where its values have one, what is cut at its right without a sign, a title without a machine, and
a long page without contents.
"""
import html
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

# Runs in the page when it is complete, and leaves what it found in the page's own text.
PROBE = """
<script>
window.pageErrors = [];
window.addEventListener('error', e => window.pageErrors.push(String(e.message)));
window.addEventListener('load', () => setTimeout(async () => {
  const found = window.pageErrors.map(e => 'script: ' + e);
  const width = document.documentElement.scrollWidth;
  if (width > window.innerWidth + 1) found.push('page: ' + width + ' px wide in a window of ' + window.innerWidth);
  document.querySelectorAll('svg').forEach((svg, number) => {
    const name = (svg.querySelector('text') || {textContent: '?'}).textContent;
    const texts = [...svg.querySelectorAll('text')].filter(t => t.textContent.trim() && t.getBoundingClientRect().width > 0);
    const boxes = texts.map(t => t.getBoundingClientRect());
    for (let i = 0; i < boxes.length; i++) for (let j = 0; j < i; j++) {
      const a = boxes[i], b = boxes[j];
      const dx = Math.min(a.right, b.right) - Math.max(a.left, b.left);
      const dy = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
      // A box is higher than its letters: a third of it may be shared.
      if (dx > 1 && dy > 0.35 * Math.min(a.height, b.height))
        found.push('figure "' + name + '": "' + texts[i].textContent + '" lies on "' + texts[j].textContent + '"');
    }
    if (texts.length && !texts.some(t => /\\(.+\\)|\\[.+\\]|µ|μ|order|factor|share|zone|ratio|part/i.test(t.textContent)))
      found.push('figure "' + name + '" names no unit');
  });
  document.querySelectorAll('.view, .scroll').forEach(box => {
    if (box.scrollWidth <= box.clientWidth + 1) return;
    const caption = box.parentElement.querySelector('figcaption');
    const sign = box.matches('.view') ? caption && getComputedStyle(caption, '::after').content.includes('→')
      : getComputedStyle(box).backgroundImage.includes('gradient');
    if (!sign) found.push('cut without a sign: ' + box.textContent.trim().slice(0, 60));
    // A computer's window has room for every column.
    if (box.matches('.scroll') && window.innerWidth >= 1400)
      found.push('a table of ' + box.scrollWidth + ' px is cut at ' + box.clientWidth + ': ' + box.textContent.trim().slice(0, 60));
  });
  document.querySelectorAll('figure .view').forEach(view => {
    const svg = view.querySelector('svg'), metadata = svg && svg.querySelector('metadata');
    if (!metadata) return;
    const r = JSON.parse(metadata.textContent)[0].r, whole = svg.getAttribute('viewBox').split(' ').map(Number);
    const box = svg.getBoundingClientRect();
    if (!box.width) return;
    svg.dispatchEvent(new PointerEvent('pointermove', { clientX: box.left + (r[0] + r[2]) / 2 / whole[2] * box.width,
      clientY: box.top + (r[1] + r[3]) / 2 / whole[3] * box.height }));
    const read = view.querySelector('.read');
    if (!read || read.hidden || !/\d/.test(read.textContent)) found.push('no value at the pointer: ' + svg.querySelector('title').textContent);
  });
  // The first figure as a file: the link that the button would follow.
  const button = document.querySelector('figure .save');
  if (document.querySelector('figure .view metadata') && !button) found.push('no figure can be saved');
  if (button) {
    const saved = new Promise(done => { HTMLAnchorElement.prototype.click = function () { done(this); }; setTimeout(done, 2000); });
    button.click();
    const link = await saved;
    if (!link || !link.href.startsWith('data:image/png') || link.href.length < 4000 || !link.download.endsWith('.png'))
      found.push('the first figure is not saved as PNG');
  }
  if (document.querySelector('h1').textContent.trim() === 'muspin') found.push('the title names no machine');
  if (document.documentElement.scrollHeight > 3 * window.innerHeight && document.querySelectorAll('section').length > 1
    && !document.querySelector('nav')) found.push('more than three screens without contents');
  const answer = document.createElement('pre');
  answer.id = 'probe-answer';
  answer.textContent = JSON.stringify(found);
  document.body.appendChild(answer);
}, 300));
</script>
"""


def findings(browser, page, width, dark):
    """What the probe says about a page."""
    with open(page, encoding="utf-8") as text:
        source = text.read()
    with tempfile.TemporaryDirectory() as place:
        probed = os.path.join(place, "page.html")
        with open(probed, "w", encoding="utf-8") as text:
            text.write(source.replace("<head>", "<head>" + PROBE, 1))
        scheme = ["--blink-settings=preferredColorScheme=0"] if dark else []
        command = [browser, "--headless", "--no-sandbox", "--disable-gpu", f"--window-size={width},2000"]
        command += scheme + ["--virtual-time-budget=4000", "--dump-dom", "file://" + probed]
        dom = subprocess.run(command, capture_output=True, text=True, timeout=300).stdout
    answer = re.search(r'<pre id="probe-answer">(.*?)</pre>', dom, re.S)
    if not answer:
        return ["the page did not finish"]
    return json.loads(html.unescape(answer.group(1)))


def main():
    browser = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if not browser:
        print("chromium is not installed: nothing is looked at")
        return 77
    if len(sys.argv) < 2:
        print(__doc__)
        return 2
    bad = 0
    for folder in sys.argv[1:]:
        page = os.path.abspath(os.path.join(folder, "report.html"))
        for width in (1400, 420):
            for dark in (False, True):
                found = findings(browser, page, width, dark)
                look = f"{folder} at {width} px, {'dark' if dark else 'light'}"
                print(f"{look}: {'nothing found' if not found else ''}")
                for line in found:
                    print(f"  {line}")
                bad += bool(found)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
