// A chart as SVG, as wide as its place. Series are lines with bands about them, areas of a stack,
// or levels over the width of a sensor's band.

function svgElement(name, attributes, text) {
  const element = document.createElementNS('http://www.w3.org/2000/svg', name);
  for (const key in attributes) element.setAttribute(key, attributes[key]);
  if (text !== undefined) element.textContent = text;
  return element;
}

function ticks(low, high, most) {
  const least = (high - low) / most;
  const ten = 10 ** Math.floor(Math.log10(least));
  const step = [1, 2, 5, 10].map((times) => times * ten).find((step) => step >= least * (1 - 1e-9));
  const digits = Math.max(0, Math.ceil(-Math.log10(step) - 1e-9));
  const values = [];
  for (let i = Math.ceil(low / step - 1e-6); i * step <= high + 1e-6 * step; i++) {
    values.push([i * step, (i * step).toFixed(digits)]);
  }
  return values;
}

class Chart {
  // `say` turns a wavelength into the text below the chart.
  constructor(host, { title, y, height, say, least }) {
    Object.assign(this, { host, title, y, height, say, least, series: [], range: null, at: null });
    host.classList.add('chart');
    this.svg = svgElement('svg', { tabindex: 0, role: 'img', 'aria-label': title });
    this.readout = document.createElement('p');
    this.readout.className = 'readout quiet';
    this.readout.setAttribute('aria-live', 'polite');
    host.append(this.svg, this.readout);
    new ResizeObserver(() => this.draw()).observe(host);
    this.listen();
  }

  set(series, whole, y) {
    this.series = series;
    this.whole = whole;
    this.y = y ?? this.y;
    this.draw();
  }

  span() {
    return this.range ?? this.whole;
  }

  zoom(factor) {
    const [from, to] = this.span();
    const middle = this.at ?? (from + to) / 2;
    this.show([middle - (middle - from) * factor, middle + (to - middle) * factor]);
  }

  show(range) {
    const [first, last] = this.whole;
    const width = Math.min(last - first, Math.max(range[1] - range[0], 0.02 * (last - first)));
    const from = Math.min(Math.max(range[0], first), last - width);
    this.range = width >= last - first - 1e-9 ? null : [from, from + width];
    this.draw();
  }

  point(um) {
    const first = this.series[0];
    if (!first) return;
    const near = first.x.reduce((a, b) => Math.abs(b - um) < Math.abs(a - um) ? b : a);
    this.at = near;
    this.readout.textContent = this.say(near);
    this.draw();
  }

  listen() {
    const { svg } = this;
    let start = null;
    const um = (event) => {
      const box = svg.getBoundingClientRect();
      const [from, to] = this.span();
      const share = (event.clientX - box.left - this.left) / (this.right - this.left);
      return from + Math.min(1, Math.max(0, share)) * (to - from);
    };
    svg.addEventListener('pointerdown', (event) => {
      if (event.pointerType !== 'touch') start = um(event);
    });
    svg.addEventListener('pointermove', (event) => {
      this.dragged = start === null ? null : [start, um(event)];
      this.point(um(event));
    });
    svg.addEventListener('pointerup', (event) => {
      const range = start === null ? null : [start, um(event)].sort((a, b) => a - b);
      start = this.dragged = null;
      const [from, to] = this.span();
      if (range && range[1] - range[0] > 0.02 * (to - from)) this.show(range);
      else this.point(um(event));
    });
    svg.addEventListener('pointerleave', () => {
      start = this.dragged = null;
      this.draw();
    });
    svg.addEventListener('dblclick', () => this.show(this.whole));
    svg.addEventListener('keydown', (event) => {
      const [from, to] = this.span();
      const step = this.series[0] ? this.step() : 0;
      const by = { ArrowLeft: -1, ArrowRight: 1, PageUp: -10, PageDown: 10 }[event.key];
      const next = (this.at ?? (from + to) / 2) + by * step;
      const shift = by * 0.1 * (to - from);
      if (by && event.shiftKey) this.show([from + shift, to + shift]);
      else if (by) this.point(Math.min(to, Math.max(from, next)));
      else if (event.key === '+') this.zoom(0.6);
      else if (event.key === '-') this.zoom(1 / 0.6);
      else if (event.key === '0' || event.key === 'Escape') this.show(this.whole);
      else return;
      event.preventDefault();
    });
  }

  step() {
    const { x } = this.series[0];
    return x.length < 2 ? 0 : (x[x.length - 1] - x[0]) / (x.length - 1);
  }

  limits(from, to) {
    let low = Infinity, high = -Infinity;
    for (const series of this.series) {
      const { x, y, base, bands } = series;
      for (let i = 0; i < x.length; i++) {
        if (x[i] < from || x[i] > to) continue;
        const ends = [y[i], base && base[i], ...(bands ?? []).flat().map((end) => end[i])];
        for (const value of ends) {
          if (!Number.isFinite(value)) continue;
          low = Math.min(low, value);
          high = Math.max(high, value);
        }
      }
    }
    if (low > high) [low, high] = [0, 1];
    if (this.least !== undefined) low = Math.min(low, this.least);
    const margin = Math.max(0.06 * (high - low), 1e-4);
    return [this.least === low ? low : low - margin, high + margin];
  }

  draw() {
    const width = Math.max(280, this.host.clientWidth || 900);
    const height = Math.min(this.height, Math.max(240, 0.62 * width));
    const { svg } = this;
    svg.replaceChildren();
    svg.setAttribute('viewBox', `0 0 ${width} ${height}`);
    svg.setAttribute('height', height);
    if (!this.whole || !this.series.length) return;
    const [from, to] = this.span();
    const [low, high] = this.limits(from, to);
    Object.assign(this, { left: 66, right: width - 12, top: 10, bottom: height - 44 });
    const { left, right, top, bottom } = this;
    const x = (um) => left + (um - from) / (to - from) * (right - left);
    const y = (value) => bottom - (value - low) / (high - low) * (bottom - top);
    const add = (name, attributes, text) => svg.append(svgElement(name, attributes, text));
    for (const [value, label] of ticks(from, to, width < 500 ? 5 : 9)) {
      add('line', { x1: x(value), x2: x(value), y1: top, y2: bottom, class: 'grid' });
      add('text', { x: x(value), y: bottom + 17, 'text-anchor': 'middle' }, label);
    }
    for (const [value, label] of ticks(low, high, 7)) {
      add('line', { x1: left, x2: right, y1: y(value), y2: y(value), class: 'grid' });
      add('text', { x: left - 7, y: y(value) + 4, 'text-anchor': 'end' }, label);
    }
    add('text', { x: (left + right) / 2, y: height - 8, 'text-anchor': 'middle' },
      'Wavelength (µm)');
    add('text', { x: 13, y: (top + bottom) / 2, 'text-anchor': 'middle',
      transform: `rotate(-90 13 ${(top + bottom) / 2})` }, this.y);
    const id = `clip${Chart.number = (Chart.number ?? 0) + 1}`;
    const clip = svgElement('clipPath', { id });
    clip.append(svgElement('rect', { x: left, y: top, width: right - left, height: bottom - top }));
    const inside = svgElement('g', { 'clip-path': `url(#${id})` });
    svg.append(clip, inside);
    const put = (name, attributes) => inside.append(svgElement(name, attributes));
    const near = ({ x: um }, i) =>
      um[Math.min(i + 1, um.length - 1)] >= from && um[Math.max(i - 1, 0)] <= to;
    const line = (series, values) => {
      let path = '', pen = 'M';
      values.forEach((value, i) => {
        if (!near(series, i)) return;
        if (!Number.isFinite(value)) { pen = 'M'; return; }
        path += `${pen}${x(series.x[i]).toFixed(2)} ${y(value).toFixed(2)}`;
        pen = 'L';
      });
      return path;
    };
    const area = (series, lower, upper) => {
      const there = [], back = [];
      series.x.forEach((um, i) => {
        if (!near(series, i) || !Number.isFinite(lower[i] + upper[i])) return;
        there.push(`${x(um).toFixed(2)} ${y(upper[i]).toFixed(2)}`);
        back.unshift(`${x(um).toFixed(2)} ${y(lower[i]).toFixed(2)}`);
      });
      return there.length ? `M${there.concat(back).join('L')}Z` : '';
    };
    for (const series of this.series) {
      const { colour } = series;
      if (series.base) {
        put('path', { d: area(series, series.base, series.y), fill: colour, 'fill-opacity': 0.8 });
      }
      for (const [below, above] of series.bands ?? []) {
        put('path', { d: area(series, below, above), fill: colour, 'fill-opacity': 0.24 });
      }
    }
    for (const series of this.series) {
      if (series.base) continue;
      const style = { fill: 'none', stroke: series.colour, 'stroke-width': 1.8,
        'stroke-dasharray': series.dash ?? 'none', 'stroke-linejoin': 'round' };
      if (series.over) {
        series.over.forEach(([first, last], i) => put('path', { ...style, 'stroke-width': 3,
          d: `M${x(first)} ${y(series.y[i])}H${x(last)}` }));
      } else if (series.x.length === 1) {
        put('circle', { cx: x(series.x[0]), cy: y(series.y[0]), r: 4, fill: series.colour });
      } else {
        put('path', { ...style, d: line(series, series.y) });
      }
    }
    if (this.dragged) {
      const [a, b] = this.dragged.map(x).sort((a, b) => a - b);
      put('rect', { x: a, width: b - a, y: top, height: bottom - top, fill: 'var(--c0)',
        'fill-opacity': 0.15 });
    }
    if (this.at !== null && this.at >= from && this.at <= to) {
      put('line', { x1: x(this.at), x2: x(this.at), y1: top, y2: bottom, stroke: 'var(--quiet)',
        'stroke-dasharray': '3 3' });
      for (const series of this.series) {
        const value = series.over || series.base ? NaN : interpolated(series.x, series.y, this.at);
        if (Number.isFinite(value)) {
          put('circle', { cx: x(this.at), cy: y(value), r: 3.5, fill: series.colour });
        }
      }
    }
    add('rect', { x: left, y: top, width: right - left, height: bottom - top, class: 'frame' });
  }
}
