// Several runs on one page: curves, differences with their errors, the band that pulls them apart.

function compare(runs) {
  let reference = 0;
  main.append(h('h1', {}, page.title), h('p', { class: 'answer' }, page.answer));
  const wide = [Math.min(...runs.map((run) => run.um[0])),
    Math.max(...runs.map((run) => run.um[run.um.length - 1]))];
  if (wide[0] === wide[1]) wide.splice(0, 2, wide[0] - 0.1, wide[1] + 0.1);
  const pen = (i) => ({ colour: COLOURS[i % 6], dash: DASHES[Math.floor(i / 6) % 4] });
  const curves = runs.map((run, i) => ({ name: run.name, ...pen(i), x: run.um, y: run.emissivity,
    bands: [about(run.emissivity, run.parts.total)] }));

  const host = h('div');
  const say = (um) => {
    const each = curves.map(({ name, x, y }) => `${name} ${digits(interpolated(x, y, um))}`);
    return `${Number(um.toFixed(4))} µm: ${each.join(', ')}`;
  };
  const chart = new Chart(host, { title: 'Emissivity of all runs', y: '', height: 430, say });
  section('Curves', h('div', { class: 'bar' }, zoomButtons(chart)), host,
    h('div', { class: 'keys' }, keysOf(curves),
      h('span', { class: 'quiet' }, 'bands: total uncertainty at 95 %')));
  chart.set(curves, wide, 'Emissivity');

  const rows = runs.map((run) => {
    const windows = page.windows.map((name) => run.windows[name] ?? '–');
    return [run.name, ...windows, run.warnings.length || ''];
  });
  section('Numbers', tableOf(['run', ...page.windows, 'warnings'], rows));

  const differences = h('div'), pulls = h('div'), keys = h('div', { class: 'keys' });
  let said = [];
  const sayApart = (um) => {
    const each = said.map(({ name, x, y, widths }) => {
      const width = interpolated(x, widths, um);
      return `${name} ${signed(interpolated(x, y, um))} ± ${digits(width)}`;
    });
    return `${Number(um.toFixed(4))} µm: ${each.join(', ')}`;
  };
  const apart = new Chart(differences, { title: 'Differences of the runs', y: '', height: 320,
    say: sayApart });

  function show() {
    const a = runs[reference];
    const at = (run, values, um) => interpolated(run.um, values, um);
    said = runs.map((run, i) => {
      const y = a.um.map((um, band) => at(run, run.emissivity, um) - a.emissivity[band]);
      const widths = a.um.map((um, band) =>
        Math.hypot(at(run, run.parts.total, um), a.parts.total[band]));
      return { name: `${run.name} less ${a.name}`, ...pen(i), x: a.um, y, widths, run,
        bands: [about(y, widths)] };
    }).filter((one) => one.run !== a);
    apart.set(said, wide, 'Difference');
    keys.replaceChildren(...keysOf(said));
    const row = ({ name, x, y, widths }) => {
      // What rounding in files makes is no difference.
      const z = (i) => Math.abs(y[i]) < 1e-7 ? 0 : 1.96 * y[i] / widths[i];
      const known = x.map((um, i) => ({ um, off: y[i], z: z(i) }))
        .filter(({ off }) => Number.isFinite(off));
      if (!known.length) return [name, 'no band in common'];
      const mean = (of) => known.map(of).reduce((sum, value) => sum + value, 0) / known.length;
      const most = known.reduce((a, b) => Math.abs(b.z) > Math.abs(a.z) ? b : a);
      const within = known.filter(({ z }) => Math.abs(z) <= 1.96).length;
      return [name, digits(Math.sqrt(mean(({ off }) => off * off))), signed(mean(({ off }) => off)),
        `${within} of ${known.length}`, `${Number(most.um.toFixed(4))} µm`, signed(most.off),
        most.z.toFixed(1)];
    };
    pulls.replaceChildren(tableOf(['difference', 'RMS', 'bias', 'agree at 95 %', 'apart most at',
      'there', 'z'], said.map(row)));
  }
  const select = h('select', { id: 'reference', onchange: () => {
    reference = Number(select.value);
    show();
  } }, runs.map((run, i) => h('option', { value: i }, run.name)));
  const bar = h('div', { class: 'bar' }, h('label', { for: 'reference' }, 'Reference'), select,
    zoomButtons(apart));
  section('Differences', bar, differences, keys, pulls, h('p', { class: 'quiet' },
    'Bands: half-widths of both results at 95 %, added as squares. z is the difference in standard '
    + 'errors.'));
  show();
  section('Runs', runs.map((run) => h('div', {}, h('h3', {}, run.name),
    h('p', {}, run.answer), run.limit ? h('p', { class: 'quiet' }, run.limit) : null,
    run.warnings.length ? h('div', { class: 'warnings' }, list(run.warnings)) : null,
    run.link ? h('p', {}, h('a', { href: encodeURI(run.link) }, 'its own page')) : null)));
}
