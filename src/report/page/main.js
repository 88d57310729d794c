// The page of one run, or of several compared.

const page = JSON.parse(document.getElementById('data').textContent);
const main = document.getElementById('page');
document.title = page.title;

const QUANTITIES = {
  emissivity: { label: 'Emissivity', unit: '', places: 4 },
  l: { label: 'Radiance (W m⁻² sr⁻¹ µm⁻¹)', unit: ' W m⁻² sr⁻¹ µm⁻¹', places: 4 },
  k: { label: 'Brightness temperature (K)', unit: ' K', places: 2 },
};

const about = (values, widths) => [
  values.map((value, i) => value - widths[i]), values.map((value, i) => value + widths[i])];

// Buttons of which one is pressed.
function choice(options, chosen, press) {
  const buttons = options.map(([key, text]) => h('button', { type: 'button', id: `show-${key}`,
    'aria-pressed': String(key === chosen), onclick: () => {
      buttons.forEach((button, i) =>
        button.setAttribute('aria-pressed', String(options[i][0] === key)));
      press(key);
    } }, text));
  return buttons;
}

function zoomButtons(chart) {
  const button = (label, text, press) =>
    h('button', { type: 'button', 'aria-label': label, title: label, onclick: press }, text);
  return [h('span', { class: 'gap' }), button('Zoom in', '+', () => chart.zoom(0.6)),
    button('Zoom out', '−', () => chart.zoom(1 / 0.6)),
    button('The whole range', 'all', () => chart.show(chart.whole))];
}

function heading(run) {
  main.append(h('h1', {}, run.heading), h('p', { class: 'answer' }, run.answer));
  if (run.limit) main.append(h('p', {}, run.limit));
  for (const note of run.notes) main.append(h('p', { class: 'quiet' }, note));
  if (run.warnings.length) {
    main.append(h('div', { class: 'warnings', role: 'note' },
      h('strong', {}, run.warnings.length > 1 ? 'Warnings' : 'Warning'), list(run.warnings)));
  }
}

// The curves of one run with what is measured and what the sliders say.
function curveOf(run) {
  const whatIf = run.table ? new WhatIf(run, page, () => show()) : null;
  const falseColour = whatIf && run.light ? new FalseColour(run) : null;
  const measured = [], problems = [];
  let quantity = 'emissivity';
  const host = h('div');
  const chart = new Chart(host, { title: 'Emissivity by wavelength', y: '', height: 430,
    say: (um) => said(um) });
  const keys = h('div', { class: 'keys' });
  const notes = h('div', { class: 'quiet', 'aria-live': 'polite' });
  let shown = [];

  // What a change of the emissivity does to the radiance.
  const contrast = run.um.map((um, i) =>
    Math.abs(planck(um, run.temperature_k) - run.l_downwelling[i]));

  function series() {
    const { um } = run;
    const asRun = { emissivity: run.emissivity, l: run.l_target,
      k: run.l_target.map((l, i) => brightness(um[i], l)) };
    const scaled = (widths, i) => quantity === 'emissivity' ? widths[i]
      : quantity === 'l' ? widths[i] * contrast[i]
        : widths[i] * contrast[i] / planckSlope(um[i], asRun.k[i]);
    const widths = [run.parts.total, run.parts.rays].filter((part) => part)
      .map((part) => part.map((_, i) => scaled(part, i)));
    const now = whatIf?.isChanged ? whatIf.curves() : null;
    const bands = widths.map((width) => about(asRun[quantity], width));
    const all = [{ name: 'as traced', colour: COLOURS[0], x: um, y: asRun[quantity], bands }];
    if (now) all.push({ name: 'now', colour: COLOURS[1], x: um, y: now[quantity], dash: '8 3' });
    if (whatIf?.sensor) {
      const seen = whatIf.bands(now ?? asRun).filter((band) => band.emissivity !== undefined);
      if (seen.length) {
        all.push({ name: `${whatIf.sensor}, nominal bands`, colour: COLOURS[5],
          over: seen.map((band) => band.range), y: seen.map((band) => band[quantity]),
          x: seen.map((band) => (band.range[0] + band.range[1]) / 2) });
      }
    }
    if (quantity === 'emissivity') {
      measured.forEach((file, i) => all.push({ name: file.name, colour: COLOURS[2 + i % 3],
        dash: DASHES[Math.floor(i / 3) % 4], x: file.x, y: file.y }));
    }
    return { all, widths, now };
  }

  function said(um) {
    const { places, unit } = QUANTITIES[quantity];
    const parts = shown.all.filter((one) => !one.over).map((one, i) => {
      const value = interpolated(one.x, one.y, um);
      if (!Number.isFinite(value)) return null;
      const at = i === 0 ? run.um.indexOf(um) : -1;
      const width = at < 0 ? '' : ` ± ${shown.widths[0][at].toFixed(places)}`;
      return `${one.name} ${value.toFixed(places)}${width}${unit}`;
    });
    return `${Number(um.toFixed(4))} µm: ${parts.filter((part) => part).join(', ')}`;
  }

  function show() {
    shown = series();
    const whole = [run.um[0], run.um[run.um.length - 1]];
    const wide = whole[0] === whole[1] ? [whole[0] - 0.1, whole[1] + 0.1] : whole;
    chart.set(shown.all, wide, QUANTITIES[quantity].label);
    keys.replaceChildren(...keysOf(shown.all),
      h('span', { class: 'quiet' }, 'bands: total uncertainty at 95 %; darker: the rays alone'));
    if (chart.at !== null) chart.readout.textContent = said(chart.at);
    else chart.readout.textContent = 'Point at the curve, or move along it with the arrow keys.';
    notes.replaceChildren(...measured.map((file) => h('p', {}, compared(run, file))),
      ...problems.map((problem) => h('p', { role: 'alert' }, problem)));
    if (whatIf) told(shown.now);
  }

  const bandsHost = h('div'), command = h('pre', { id: 'command' });
  const error = h('p', { class: 'quiet' });
  function told(now) {
    const asRun = { emissivity: run.emissivity, l: run.l_target };
    const seen = whatIf.sensor ? whatIf.bands(now ?? asRun) : [];
    bandsHost.replaceChildren(...(seen.length ? [tableOf(
      ['band', 'µm', 'emissivity', 'radiance', 'brightness temperature, K'],
      seen.map(({ name, range, emissivity, l, k }) => [name, `${range[0]}–${range[1]}`,
        digits(emissivity), digits(l), digits(k, 2)]))] : []));
    command.textContent = whatIf.command();
    error.textContent = whatIf.hasSpectra
      ? 'The uncertainty of other spectra is not shown here: the command gives it.' : '';
    falseColour?.show(run.table.materials.map((_, m) => whatIf.spectrumOf(m)),
      (now ?? { emissivity: run.emissivity }).emissivity);
  }

  async function take(files) {
    problems.length = 0;
    // The list of a drop is empty once its event has ended.
    for (const file of [...files]) {
      try {
        const one = readSpectrum(file.name, await file.text());
        measured.push(one);
        if (whatIf) {
          const { um } = run;
          const [first, last] = [one.x[0], one.x[one.x.length - 1]];
          if (first <= um[0] + 1e-9 && last >= um[um.length - 1] - 1e-9) whatIf.measured.push(one);
        }
      } catch (problem) {
        problems.push(problem.message);
      }
    }
    show();
    if (whatIf?.host) whatIf.build(whatIf.host);
  }
  const input = h('input', { type: 'file', id: 'measured', multiple: true,
    onchange: () => take(input.files) });
  const bar = h('div', { class: 'bar' }, choice([['emissivity', 'Emissivity'], ['l', 'Radiance'],
    ['k', 'Brightness temperature']], quantity, (key) => { quantity = key; show(); }),
  h('label', { class: 'file' }, input, 'Add measured spectra'), zoomButtons(chart));
  const whole = h('div');
  main.append(whole);
  whole.append(h('h2', {}, 'Curve'), h('div', { class: 'live' }, bar, host, keys), notes,
    h('p', { class: 'quiet no-print' }, 'Drop files of measured spectra onto the chart: two '
      + 'columns, or text of the ECOSTRESS library. Drag to zoom. Keys: arrows, + and −, 0.'));
  for (const kind of ['dragover', 'dragleave', 'drop']) {
    whole.addEventListener(kind, (event) => {
      event.preventDefault();
      host.classList.toggle('dropping', kind === 'dragover');
      if (kind === 'drop') take(event.dataTransfer.files);
    });
  }
  if (whatIf) {
    const controls = h('div', { class: 'no-print' });
    whatIf.build(controls);
    const result = h('div', {}, bandsHost, h('p', {}, 'The same with its uncertainty:'), command,
      error);
    // On paper only what was changed.
    const asked = h('div', {}, h('h2', {}, 'What if'), h('p', { class: 'quiet no-print' },
      'Paths are not traced again: the bounce table gives the bed for any spectra.'),
    controls, h('div', { class: 'columns picture-first' }, falseColour?.element(), result));
    window.addEventListener('beforeprint', () =>
      asked.classList.toggle('no-print', !whatIf.isChanged && !whatIf.sensor));
    window.addEventListener('afterprint', () => asked.classList.remove('no-print'));
    whole.append(asked);
  } else if (run.no_sliders) {
    section('What if', h('p', {}, run.no_sliders));
  }
  show();
  return { show };
}

// Root mean square, bias and worst band of a curve less a measured one.
function compared(run, file) {
  let squares = 0, sum = 0, number = 0, worst = [0, 0];
  file.x.forEach((um, i) => {
    const off = interpolated(run.um, run.emissivity, um) - file.y[i];
    if (!Number.isFinite(off)) return;
    squares += off * off;
    sum += off;
    number++;
    if (Math.abs(off) > Math.abs(worst[0])) worst = [off, um];
  });
  if (!number) return `${file.name} holds none of these wavelengths`;
  return `As traced less ${file.name}: RMS ${digits(Math.sqrt(squares / number))}, bias `
    + `${signed(sum / number)}, worst band ${signed(worst[0])} at `
    + `${Number(worst[1].toFixed(3))} µm`;
}

function budgetOf(run) {
  const { um, parts } = run;
  const names = { beds: 'differences between beds', rays: 'rays', rim: 'rim of the view',
    floor: 'floor', given_up: 'paths given up',
    apart: 'hulls that keep fines apart' };
  const shares = { ...parts };
  // Rays and beds add as squares: each has its part of their sum.
  const chance = um.map((_, i) => Math.hypot(parts.rays[i], parts.beds?.[i] ?? 0));
  const part = (of) => um.map((_, i) => chance[i] > 0 ? (of[i] ** 2) / chance[i] : 0);
  shares.rays = part(parts.rays);
  shares.beds = parts.beds && part(parts.beds);
  let base = um.map(() => 0);
  const counts = (key) => shares[key] && shares[key].some((share) => share >= 5e-6);
  const keys = Object.keys(names).filter((key) => key === 'rays' || counts(key));
  const stacked = keys.map((key, i) => {
    const top = base.map((from, band) => from + shares[key][band]);
    const one = { name: names[key], key, colour: COLOURS[i], x: um, y: top, base };
    base = top;
    return one;
  });
  const host = h('div');
  const say = (at) => {
    const i = um.indexOf(at);
    const each = stacked.map(({ name, key }) => `${name} ${digits(parts[key][i])}`);
    return `${Number(at.toFixed(4))} µm: total ± ${digits(parts.total[i])}: ${each.join(', ')}`;
  };
  const title = 'Parts of the uncertainty by wavelength';
  const chart = new Chart(host, { title, y: '', height: 300, say, least: 0 });
  const not = Object.entries(run.not_included).map(([name, text]) => `${name}: ${text}`);
  section('What the uncertainty consists of', h('div', { class: 'bar' }, zoomButtons(chart)), host,
    h('div', { class: 'keys' }, keysOf(stacked)), run.limit ? h('p', {}, run.limit) : null,
    h('p', { class: 'quiet' }, 'Half-widths in emissivity at 95 %. Rays and beds add as '
      + 'squares, the others are bounds and add up.'),
    not.length ? h('details', {}, h('summary', {}, 'Not included'), list(not)) : null);
  const wide = um.length > 1 ? [um[0], um[um.length - 1]] : [um[0] - 0.1, um[0] + 0.1];
  chart.set(stacked, wide, '± emissivity');
}

if (page.runs.length === 1) {
  const [run] = page.runs;
  heading(run);
  const { show } = curveOf(run);
  pictures(run);
  budgetOf(run);
  if (run.details.length) section('More numbers', list(run.details));
  provenance(run);
  filesOf(run);
  window.addEventListener('beforeprint', () => {
    show();
    document.querySelectorAll('details').forEach((details) => { details.open = true; });
  });
} else {
  compare(page.runs);
}
main.append(h('p', { class: 'quiet' }, `Written by soilsig ${page.version}.`));
