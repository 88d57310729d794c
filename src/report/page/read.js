// Spectra from files of the user's disk: emissivity by wavelength in um.

function readSpectrum(name, text) {
  const lines = text.replace(/^\ufeff/, '').split(/\r\n|\n|\r/);
  const header = {};
  const isLibrary = /^Name:/.test(lines[0]);
  let rows = [], heading = null;
  for (const line of lines) {
    const trimmed = line.trim();
    if (!trimmed || trimmed.startsWith('#')) continue;
    const pair = isLibrary && !rows.length && /^([A-Za-z][^:]*):(.*)$/.exec(trimmed);
    if (pair) {
      header[pair[1].trim().toLowerCase()] = pair[2].trim();
      continue;
    }
    const mark = [',', ';', '\t'].find((mark) => trimmed.includes(mark));
    const fields = (mark ? trimmed.split(mark) : trimmed.split(/\s+/)).map((field) => field.trim());
    const numbers = fields.map((field) => field === '' ? NaN : Number(field));
    if (Number.isFinite(numbers[0])) {
      rows.push(numbers);
    } else if (!rows.length && !heading) {
      heading = fields;
    } else if (!isLibrary) {
      throw new Error(`${name}: "${trimmed.slice(0, 40)}" is not a row of numbers`);
    }
  }
  const named = heading ? heading.indexOf('emissivity') : -1;
  const column = named > 0 ? named : 1;
  const says = [header['y units'], header['measurement'], heading && heading[column]].join(' ');
  if (/transmi|transit/i.test(says)) throw new Error(`${name} is a transmission spectrum`);
  const unit = [header['x units'], heading && heading[0]].join(' ').toLowerCase();
  const toUm = /wavenumber|cm-1|cm\^-1|1\/cm/.test(unit) ? (x) => 1e4 / x
    : /nanomet|\(nm\)|\[nm\]|_nm|^nm$/.test(unit.trim()) ? (x) => x / 1e3 : (x) => x;
  let points = rows.map((row) => [toUm(row[0]), row[column]]);
  points = points.filter(([um, y]) => um > 0 && Number.isFinite(y) && y > -1e30);
  const isReflectance = /reflect|reflec|albedo/i.test(says);
  const factor = /percent|%/i.test(says) ? 0.01 : 1;
  points = points.map(([um, y]) => [um, isReflectance ? 1 - factor * y : factor * y]);
  points.sort((a, b) => a[0] - b[0]);
  if (points.length < 2) throw new Error(`${name} has no two columns of numbers`);
  if (points.some(([, y]) => y < -0.2 || y > 1.2)) {
    throw new Error(`${name} has values beyond 0 to 1: write emissivity, or name the quantity`);
  }
  const label = header.name ? `${header.name} (${name})` : name;
  return { name: label, file: name, x: points.map((p) => p[0]), y: points.map((p) => p[1]) };
}
