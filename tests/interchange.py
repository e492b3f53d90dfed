"""Runs the Python blocks of the guide to the solvers on a design with its problem files.

usage: python3 tests/interchange.py DESIGN   (a folder that `muspin design --problem --out DESIGN` wrote)
Needs numpy, scipy and control.
"""
import os
import re
import sys

if len(sys.argv) != 2 or not os.path.isdir(os.path.join(sys.argv[1], "problem")):
    sys.exit(__doc__)
guide = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src", "guide", "solvers.md")
with open(guide, encoding="utf-8") as text:
    blocks = re.findall(r"```python\n(.*?)```", text.read(), re.S)
os.chdir(sys.argv[1])
for number, block in enumerate(blocks, 1):
    exec(compile(block, f"block {number} of {guide}", "exec"), {})
    print(f"block {number} runs")
