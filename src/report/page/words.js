// Elements, numbers in words, and the parts of the page that do not change.

const COLOURS = ['var(--c0)', 'var(--c1)', 'var(--c2)', 'var(--c3)', 'var(--c4)', 'var(--c5)'];
const DASHES = ['none', '8 3', '2 3', '9 3 2 3'];

function h(tag, attributes, ...children) {
  const element = document.createElement(tag);
  for (const key in attributes ?? {}) {
    if (key.startsWith('on')) element.addEventListener(key.slice(2), attributes[key]);
    else if (attributes[key] !== undefined && attributes[key] !== false) {
      element.setAttribute(key, attributes[key] === true ? '' : attributes[key]);
    }
  }
  element.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return element;
}

// A section below the others.
function section(title, ...children) {
  const element = h('section', {}, h('h2', {}, title), ...children);
  document.getElementById('page').append(element);
  return element;
}

const digits = (number, places = 4) => Number.isFinite(number) ? number.toFixed(places) : '–';
const signed = (number) => (number < 0 ? '−' : '+') + Math.abs(number).toFixed(4);

function tableOf(headings, rows) {
  const head = h('tr', {}, headings.map((text) => h('th', { scope: 'col' }, text)));
  const body = rows.map((row) => h('tr', {}, row.map((cell) => h('td', {}, String(cell)))));
  return h('div', { class: 'scroll' }, h('table', {}, h('thead', {}, head), h('tbody', {}, body)));
}

function keysOf(series) {
  return series.map(({ name, colour, dash }) => {
    const sample = dash && dash !== 'none'
      ? `background: repeating-linear-gradient(90deg, ${colour} 0 .4em, transparent .4em .6em)`
      : `background: ${colour}`;
    return h('span', {}, h('i', { style: sample }), name);
  });
}

function list(items) {
  return h('ul', {}, items.map((item) => h('li', {}, item)));
}

function pictures(run) {
  const shown = run.pictures.map(({ data, text }) =>
    h('figure', {}, h('img', { src: data, alt: text }), h('figcaption', {}, text)));
  if (shown.length) section('Pictures', h('div', { class: 'columns picture-first' }, shown));
}

function provenance(run) {
  const { record } = run;
  if (!record) return;
  // What is named by a hash stands with the other hashes.
  const isHash = ([, value]) => /^[0-9a-f]{64}$/.test(value);
  const versions = Object.entries(record.versions);
  const hashes = (files) => files.map(([path, value]) => h('tr', {},
    h('td', { class: 'text' }, path), h('td', { class: 'text' }, h('code', {}, value))));
  const named = (of) => h('table', {}, of.map(([name, value]) =>
    h('tr', {}, h('td', {}, name), h('td', { class: 'text' }, String(value)))));
  const stages = record.stages.map((stage) =>
    [stage.name, `${stage.seconds.toFixed(2)} s`, stage.cached ? 'from the cache' : '']);
  section('Provenance',
    h('p', {}, 'The command:'), h('pre', {}, record.command.join(' ')),
    h('p', { class: 'quiet' }, 'soilsig replay run.json repeats it and compares the results.'),
    h('div', { class: 'columns' },
      h('div', {}, h('h3', {}, 'Versions'), named(versions.filter((one) => !isHash(one)))),
      h('div', {}, h('h3', {}, 'Seeds'), named(Object.entries(record.seeds))),
      h('div', {}, h('h3', {}, 'Stages'), tableOf(['stage', 'time', ''], stages))),
    h('details', {}, h('summary', {}, 'SHA-256 of what was read and written'),
      h('div', { class: 'scroll files' }, h('table', {}, hashes(versions.filter(isHash)),
        hashes(Object.entries(record.inputs)), hashes(Object.entries(record.outputs))))));
}

function filesOf(run) {
  if (!run.files.length) return;
  const links = (files) => h('ul', {}, files.map(([file, text]) =>
    h('li', {}, h('a', { href: encodeURI(file) }, file), text ? `: ${text}` : '')));
  const ofBeds = run.files.filter(([file]) => file.startsWith('packings/'));
  const others = run.files.filter((one) => !ofBeds.includes(one));
  section('Files', links(others), ofBeds.length ? h('details', {},
    h('summary', {}, `Files of single beds (${ofBeds.length})`), links(ofBeds)) : null)
    .classList.add('no-print');
}
