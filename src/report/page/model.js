// What the bounce table and Planck's law say of other spectra and temperatures.

const C1 = 2 * 6.62607015e-34 * 299792458 ** 2 * 1e24;
const C2 = 6.62607015e-34 * 299792458 / 1.380649e-23 * 1e6;

// W m-2 sr-1 um-1.
function planck(um, k) {
  return C1 / um ** 5 / Math.expm1(C2 / (um * k));
}

function planckSlope(um, k) {
  const x = C2 / (um * k);
  return planck(um, k) * x / k / -Math.expm1(-x);
}

function brightness(um, l) {
  return l > 0 ? C2 / (um * Math.log1p(C1 / um ** 5 / l)) : NaN;
}

// 1 less the mean weight that paths bring to the sky. `spectra` holds an emissivity for each band
// of each material.
function emissivity(table, spectra, bands) {
  const { all, escaped, given_up } = table;
  const result = new Array(bands);
  const powers = spectra.map((_, m) => new Float64Array(table.most[m] + 1).fill(1));
  const sum = (states) => {
    let total = 0;
    for (const state of states) {
      let weight = state[0];
      for (let m = 0; m < powers.length; m++) weight *= powers[m][state[m + 1]];
      total += weight;
    }
    return total;
  };
  for (let band = 0; band < bands; band++) {
    powers.forEach((of, m) => {
      const rho = 1 - spectra[m][band];
      for (let n = 1; n < of.length; n++) of[n] = of[n - 1] * rho;
    });
    result[band] = 1 - (sum(escaped) + sum(given_up) / 2) / all;
  }
  return result;
}

// Straight lines between points; NaN beyond them.
function interpolated(x, y, at) {
  if (at < x[0] - 1e-9 || at > x[x.length - 1] + 1e-9) return NaN;
  let low = 0, high = x.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (x[middle] <= at) low = middle; else high = middle;
  }
  const share = x.length < 2 ? 0 : (at - x[low]) / (x[high] - x[low]);
  return y[low] + Math.min(1, Math.max(0, share)) * ((y[high] ?? y[low]) - y[low]);
}

// The mean of a curve over a band with a constant response, by trapezia.
function bandMean(x, y, [from, to]) {
  const inner = x.filter((um) => um > from && um < to);
  const nodes = [from, ...inner, to];
  const values = nodes.map((um) => interpolated(x, y, um));
  let area = 0;
  for (let i = 1; i < nodes.length; i++) {
    area += (nodes[i] - nodes[i - 1]) * (values[i] + values[i - 1]) / 2;
  }
  return area / (to - from);
}

// The temperature of a black body with that radiance in a band.
function bandTemperature(x, l, range) {
  const centre = (range[0] + range[1]) / 2;
  let k = brightness(centre, l);
  for (let i = 0; i < 8 && k > 0; i++) {
    const mean = (of) => bandMean(x, x.map((um) => of(um, k)), range);
    k += (l - mean(planck)) / mean(planckSlope);
  }
  return k;
}
