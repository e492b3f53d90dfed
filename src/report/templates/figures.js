// Values at the pointer, zoom by dragging, whole figure by a double click. Every figure has the axes of its panels as metadata:
// [{r: [left, top, right, bottom], x: [log, low, high, label, unit], y: the same}], in units of its viewBox.
(function () {
  'use strict';
  var SNAP = 36;

  function value(axis, share) {
    return axis[0] ? axis[1] * Math.pow(axis[2] / axis[1], share) : axis[1] + share * (axis[2] - axis[1]);
  }

  function words(axis, x) {
    var size = Math.abs(x);
    var text = x === 0 ? '0' : size >= 1e-3 && size < 1e6 ? String(Number(x.toPrecision(4))) : x.toExponential(3);
    return text + (axis[4] ? ' ' + axis[4] : '');
  }

  // Curves with their points; lines of the frame and of the grid have five points at most.
  function curves(svg) {
    var names = {};
    var found = [];
    Array.prototype.forEach.call(svg.querySelectorAll('polyline'), function (line) {
      var key = line.getAttribute('stroke') + '|' + (line.getAttribute('stroke-dasharray') || '');
      var points = line.getAttribute('points').trim().split(/\s+/).map(function (p) { return p.split(',').map(Number); });
      var after = line.nextElementSibling;
      if (points.length === 2 && after && after.tagName === 'text' && !(key in names)) {
        names[key] = after.textContent.trim();
      }
      if (points.length > 5) {
        var ascends = points.every(function (p, k) { return k === 0 || p[0] >= points[k - 1][0]; });
        found.push({ key: key, points: points, ascends: ascends });
      }
    });
    found.forEach(function (c) { c.name = names[c.key] || ''; });
    return found;
  }

  function inside(panel, x, y) {
    var r = panel.r;
    return x >= r[0] && x <= r[2] && y >= r[1] && y <= r[3];
  }

  // What stands at a point of a figure: every named curve of its panel at the pointer's abscissa, and beside them the nearest point
  // of a curve, or the point itself where none is near; null outside the panels.
  function reading(panels, lines, x, y) {
    var panel = panels.filter(function (p) { return inside(p, x, y); })[0];
    if (!panel) { return null; }
    var r = panel.r;
    function across(px) { return words(panel.x, value(panel.x, (px - r[0]) / (r[2] - r[0]))); }
    function up(py) { return words(panel.y, value(panel.y, (r[3] - py) / (r[3] - r[1]))); }
    var best = null;
    var least = SNAP * SNAP;
    var named = [];
    lines.forEach(function (line) {
      var there = null;
      line.points.forEach(function (p) {
        if (!inside(panel, p[0], p[1])) { return; }
        var d = (p[0] - x) * (p[0] - x) + (p[1] - y) * (p[1] - y);
        if (d < least) { least = d; best = { x: p[0], y: p[1], name: line.name }; }
        if (!there || Math.abs(p[0] - x) < Math.abs(there[0] - x)) { there = p; }
      });
      // A curve that comes back (an orbit, a locus) has no one value there.
      if (there && line.name && line.ascends && Math.abs(there[0] - x) < SNAP && named.every(function (n) { return n.name !== line.name; })) {
        named.push({ name: line.name, y: there[1] });
      }
    });
    if (named.length > 1) {
      return [across(x)].concat(named.map(function (n) { return n.name + ': ' + up(n.y); })).join('\n');
    }
    var at = best || { x: x, y: y, name: '' };
    return (at.name ? at.name + ': ' : '') + across(at.x) + ', ' + up(at.y);
  }

  // A file of the figure as it is shown, twice as fine as on the screen.
  function savePicture(svg) {
    var box = svg.viewBox.baseVal;
    var width = 2 * (svg.getBoundingClientRect().width || 600);
    var copy = svg.cloneNode(true);
    copy.setAttribute('xmlns', 'http://www.w3.org/2000/svg');
    copy.setAttribute('width', Math.round(width));
    copy.setAttribute('height', Math.round(width * box.height / box.width));
    var image = new Image();
    image.addEventListener('load', function () {
      var canvas = document.createElement('canvas');
      canvas.width = image.width;
      canvas.height = image.height;
      var context = canvas.getContext('2d');
      context.fillStyle = '#ffffff';
      context.fillRect(0, 0, canvas.width, canvas.height);
      context.drawImage(image, 0, 0);
      var link = document.createElement('a');
      link.download = svg.querySelector('title').textContent.replace(/[^A-Za-z0-9]+/g, '-') + '.png';
      link.href = canvas.toDataURL('image/png');
      link.click();
    });
    image.src = 'data:image/svg+xml;charset=utf-8,' + encodeURIComponent(new XMLSerializer().serializeToString(copy));
  }

  function equip(view) {
    var svg = view.querySelector('svg');
    var meta = svg && svg.querySelector('metadata');
    if (!meta) { return; }
    var panels = JSON.parse(meta.textContent);
    var lines = null;
    var whole = svg.getAttribute('viewBox');
    var read = document.createElement('output');
    var start = null;
    read.className = 'read';
    read.hidden = true;
    view.appendChild(read);
    var save = document.createElement('button');
    save.type = 'button';
    save.className = 'save';
    save.textContent = 'save as PNG';
    save.addEventListener('click', function () { savePicture(svg); });
    view.parentElement.querySelector('figcaption').appendChild(save);

    function place(event) {
      var box = svg.getBoundingClientRect();
      var v = svg.getAttribute('viewBox').split(' ').map(Number);
      return [v[0] + (event.clientX - box.left) / box.width * v[2], v[1] + (event.clientY - box.top) / box.height * v[3]];
    }

    svg.addEventListener('pointermove', function (event) {
      lines = lines || curves(svg);
      var p = place(event);
      var text = reading(panels, lines, p[0], p[1]);
      read.hidden = text === null;
      if (text === null) { return; }
      var box = view.getBoundingClientRect();
      read.textContent = text;
      var left = event.clientX - box.left + view.scrollLeft + 14;
      var room = view.scrollLeft + view.clientWidth - read.offsetWidth - 4;
      read.style.left = Math.max(0, Math.min(left, room)) + 'px';
      read.style.top = Math.max(0, event.clientY - box.top - 30) + 'px';
    });
    svg.addEventListener('pointerleave', function () { read.hidden = true; });
    svg.addEventListener('pointerdown', function (event) { if (event.pointerType !== 'touch') { start = place(event); event.preventDefault(); } });
    svg.addEventListener('pointerup', function (event) {
      if (!start) { return; }
      var end = place(event);
      var x = Math.min(start[0], end[0]);
      var y = Math.min(start[1], end[1]);
      var w = Math.abs(start[0] - end[0]);
      var h = Math.abs(start[1] - end[1]);
      start = null;
      if (w < 40 || h < 40) { return; }
      svg.setAttribute('viewBox', [x, y, w, h].map(Math.round).join(' '));
      svg.setAttribute('preserveAspectRatio', 'none');
      view.classList.add('zoomed');
    });
    svg.addEventListener('dblclick', function () {
      svg.setAttribute('viewBox', whole);
      svg.removeAttribute('preserveAspectRatio');
      view.classList.remove('zoomed');
    });
  }

  Array.prototype.forEach.call(document.querySelectorAll('figure .view'), equip);
}());
