// Other spectra, temperatures, skies and sensors, evaluated from the bounce table at once.

class WhatIf {
  constructor(run, page, changed) {
    Object.assign(this, { run, page, changed, choices: [], measured: [] });
    const { table } = run;
    this.kelvin = run.temperature_k;
    this.sky = null;
    this.sensor = null;
    table.materials.forEach(() => this.choices.push({ kind: 'own' }));
  }

  get isChanged() {
    return this.hasSpectra || this.kelvin !== this.run.temperature_k || this.sky !== null;
  }

  get hasSpectra() {
    return this.choices.some((choice) => choice.kind !== 'own');
  }

  spectrumOf(m) {
    const choice = this.choices[m];
    const { um, table } = this.run;
    if (choice.kind === 'constant') return um.map(() => choice.value);
    if (choice.kind === 'shipped') return this.page.spectra[choice.index].emissivity;
    const { file } = choice;
    if (choice.kind === 'file') return um.map((at) => interpolated(file.x, file.y, at));
    return table.materials[m].emissivity;
  }

  // Emissivity and radiance in each band.
  curves() {
    const { run } = this;
    const eps = this.hasSpectra
      ? emissivity(run.table, run.table.materials.map((_, m) => this.spectrumOf(m)), run.um.length)
      : run.emissivity;
    const l = run.um.map((um, i) => {
      if (run.fixed_radiance) return this.hasSpectra ? NaN : run.l_target[i];
      const sky = this.sky === null ? run.l_downwelling[i] : this.sky ? planck(um, this.sky) : 0;
      return eps[i] * planck(um, this.kelvin) + (1 - eps[i]) * sky;
    });
    return { emissivity: eps, l, k: l.map((l, i) => brightness(run.um[i], l)) };
  }

  bands(curves) {
    const sensor = this.page.sensors.find((sensor) => sensor.name === this.sensor);
    const { um } = this.run;
    return (sensor?.bands ?? []).map(({ name, range }) => {
      const [first, last] = [um[0], um[um.length - 1]];
      if (range[0] < first - 1e-9 || range[1] > last + 1e-9) return { name, range };
      const l = bandMean(um, curves.l, range);
      return { name, range, emissivity: bandMean(um, curves.emissivity, range), l,
        k: bandTemperature(um, l, range) };
    });
  }

  command() {
    const { run } = this;
    const words = ['soilsig signature', run.tables];
    this.choices.forEach((choice, m) => {
      const text = { constant: choice.value, shipped: this.page.spectra[choice.index]?.name,
        file: choice.file?.file }[choice.kind];
      if (text !== undefined) {
        const word = `${run.table.materials[m].name}=${text}`;
        words.push(`--spectrum ${/^[\w=.:/+-]+$/.test(word) ? word : `'${word}'`}`);
      }
    });
    if (this.kelvin !== run.temperature_k) words.push(`--temperature ${this.kelvin}`);
    if (this.sky !== null) words.push(`--sky ${this.sky || 'FILE (a black sky: radiance 0)'}`);
    if (this.sensor) words.push(`--sensor ${this.sensor}`);
    return words.join(' ');
  }

  reset() {
    this.choices = this.choices.map(() => ({ kind: 'own' }));
    Object.assign(this, { kelvin: this.run.temperature_k, sky: null, sensor: null });
    this.build(this.host);
    this.changed();
  }

  // The controls; built anew when files are added.
  build(host) {
    this.host = host;
    const { run, page } = this;
    const row = (label, id, control, output) => h('div', { class: 'row' },
      h('label', { for: id }, label), control, output ?? null);
    const slider = (id, min, max, step, value, moved, unit) => {
      const output = h('output', { for: id }, `${value}${unit}`);
      const input = h('input', { type: 'range', id, min, max, step, value, oninput: () => {
        output.textContent = `${input.value}${unit}`;
        moved(Number(input.value));
        this.changed();
      } });
      return [input, output];
    };
    const materials = run.table.materials.map((material, m) => {
      const id = `spectrum-${m}`;
      const options = [['own', `${material.spectrum} (as in the run)`]]
        .concat(page.spectra.map((spectrum, i) => [`shipped ${i}`, spectrum.name]))
        .concat([['constant', 'the same at every wavelength']])
        .concat(this.measured.map((file, i) => [`file ${i}`, file.name]));
      const { kind, index, file, value } = this.choices[m];
      const chosen = kind === 'shipped' ? `shipped ${index}`
        : kind === 'file' ? `file ${this.measured.indexOf(file)}` : kind;
      const select = h('select', { id, onchange: () => {
        const [kind, number] = select.value.split(' ');
        this.choices[m] = kind === 'file' ? { kind, file: this.measured[number] }
          : kind === 'shipped' ? { kind, index: Number(number) }
            : kind === 'constant' ? { kind, value: Number(constant.value) } : { kind };
        this.changed();
      } }, options.map(([key, text]) =>
        h('option', { value: key, selected: key === chosen }, text)));
      const [constant, output] = slider(`constant-${m}`, 0, 1, 0.01, value ?? 0.9, (value) => {
        this.choices[m] = { kind: 'constant', value };
        select.value = 'constant';
      }, '');
      return h('fieldset', {}, h('legend', {}, material.name),
        row('spectrum', id, select), row('constant', `constant-${m}`, constant, output));
    });
    const thermal = run.fixed_radiance
      ? h('p', { class: 'quiet' }, `Temperature and sky cannot be moved: ${run.fixed_radiance}.`)
      : h('fieldset', {}, h('legend', {}, 'Temperature and sky'),
        row('bed', 'kelvin', ...slider('kelvin', Math.min(200, Math.floor(run.temperature_k)),
          Math.max(400, Math.ceil(run.temperature_k)), 1, this.kelvin,
          (value) => { this.kelvin = value; }, ' K')),
        row('sky', 'sky', ...slider('sky', 0, 350, 1, this.sky ?? Math.round(run.sky_k ?? 0),
          (value) => { this.sky = value; }, ' K')),
        h('p', { class: 'quiet' }, 'A sky of 0 K is cold and black.'));
    const sensor = h('select', { id: 'sensor', onchange: () => {
      this.sensor = sensor.value || null;
      this.changed();
    } }, h('option', { value: '' }, 'single wavelengths'), page.sensors.map(({ name }) =>
      h('option', { value: name, selected: name === this.sensor }, name)));
    const end = h('fieldset', {}, h('legend', {}, 'Sensor'), row('bands', 'sensor', sensor));
    const reset = h('button', { type: 'button', id: 'reset', onclick: () => this.reset() },
      'Back to the run');
    host.replaceChildren(h('div', { class: 'columns' }, materials, thermal, h('div', {}, end, reset)));
  }
}

// The bed in false colour: every facet by its own spectrum at three wavelengths.
class FalseColour {
  constructor(run) {
    this.run = run;
    this.um = [11.3, 9.1, 8.3];
    this.canvas = h('canvas', { width: 1, height: 1, role: 'img', 'aria-label':
      'The bed in false colour' });
    this.before = h('b');
    this.now = h('b');
    const image = new Image();
    image.onload = () => {
      const { canvas } = this;
      canvas.width = image.width;
      canvas.height = image.height;
      const context = canvas.getContext('2d', { willReadFrequently: true });
      context.drawImage(image, 0, 0);
      this.light = context.getImageData(0, 0, image.width, image.height);
      if (this.last) this.show(...this.last);
    };
    image.src = run.light;
  }

  element() {
    return h('figure', {}, this.canvas,
      h('div', { class: 'swatches' }, h('div', {}, this.before, 'the bed as traced'),
        h('div', {}, this.now, 'the bed now')),
      h('figcaption', {}, 'False colour: emissivity at 11.3, 9.1 and 8.3 µm as red, green and '
        + 'blue. Facets of the picture have their own spectra; the two fields show the whole bed, '
        + 'with all that its facets reflect.'));
  }

  colour(values) {
    return this.um.map((um) => {
      const eps = interpolated(this.run.um, values, um);
      return Math.min(1, Math.max(0, (eps - 0.35) / 0.65));
    });
  }

  show(spectra, bed) {
    this.last = [spectra, bed];
    const css = (values) => {
      const [r, g, b] = this.colour(values).map((level) => Math.round(255 * level));
      return `background: rgb(${r},${g},${b}); print-color-adjust: exact`;
    };
    this.before.style.cssText = css(this.run.emissivity);
    this.now.style.cssText = css(bed);
    if (!this.light) return;
    const { width, height, data } = this.light;
    const colours = spectra.slice(0, 3).map((values) => this.colour(values));
    while (colours.length < 3) colours.push([0, 0, 0]);
    const picture = new ImageData(width, height);
    for (let i = 0; i < data.length; i += 4) {
      for (let channel = 0; channel < 3; channel++) {
        picture.data[i + channel] = data[i] * colours[0][channel]
          + data[i + 1] * colours[1][channel] + data[i + 2] * colours[2][channel];
      }
      picture.data[i + 3] = 255;
    }
    this.canvas.getContext('2d').putImageData(picture, 0, 0);
  }
}
