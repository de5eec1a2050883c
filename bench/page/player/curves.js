// Curves over time: uPlot charts that share a cursor, a zoom and the time of the player.

const LINE_COLOURS = {light: ['#0b62b0', '#c2410c', '#2f7d4f', '#8b3fa0', '#8a6d00', '#5d6a73'],
  dark: ['#74b6f5', '#ff9d66', '#7fd0a6', '#d49be6', '#e3c15a', '#9aa6ae']};

/** The tables of the run's CSV files: {file, part, columns}, columns by name without unit. */
async function readCurves(about, text) {
  const bytes = await inflate(text), tables = [];
  let next = 0;
  for (const {file, part, names, rows, all_rows} of about.curves) {
    const table = {file, part, rows, allRows: all_rows, columns: {}, units: {}};
    for (const column of names) {
      const name = column.replace(/ \[.*/, '');
      table.columns[name] = new Float32Array(bytes.slice(next, next + 4 * rows).buffer);
      table.units[name] = nameAndUnit(column)[1];
      next += 4 * rows;
    }
    tables.push(table);
  }
  return tables;
}

const varies = ({values}) => values.some(x => Number.isFinite(x) && x !== values[0]);

/** Charts that the tables allow: {title, unit, shown, time, lines: [{name, values}], log, level}. */
function chartsOf(run, tables) {
  const charts = [], ledger = tables.find(t => t.file === 'ledger');
  const used = new Set(['step', 'time', 'converged', 'raw42', 'natural_map', 'momentum_imbalance_x',
    'momentum_imbalance_y', 'momentum_imbalance_z', 'imbalance']);
  if (ledger) {
    const c = ledger.columns;
    const chart = (title, unit, names, more = {}) => {
      const lines = names.filter(n => c[n.of || n]).map(n => ({name: nameAndUnit(n.name || n)[0], values: n.values || c[n]}));
      names.forEach(n => used.add(n.of || n));
      const shown = lines.some(varies), thinned = ledger.allRows > ledger.rows;
      if (lines.length) charts.push({title, unit, shown, time: c.time, lines, thinned, ...more});
    };
    chart('Kinetic energy', 'J', ['kinetic', 'elastic']);
    chart('Potential energy', 'J', ['potential']);
    chart('Energy lost', 'J', [{of: 'friction_loss', name: 'by friction', values: c.friction_loss},
      {of: 'shock_loss', name: 'by shocks', values: c.shock_loss}, {of: 'wall_work', name: 'work of walls', values: c.wall_work}]);
    chart('Contacts', '', ['contacts', {of: 'active', name: 'with a force', values: c.active}], {counts: true});
    chart('Iterations', '', ['iterations'], {counts: true});
    if (c.epsilon && run.about.model === 'nscd') {
      const worst = c.epsilon.map((x, k) => Math.max(x, c.eta[k]));
      chart('Error of the step', '', [{of: 'epsilon', name: 'max(ε, η)', values: worst}], {log: true, level: run.about.tol});
    }
    used.add('eta').add('epsilon');
    const shares = overlapShares(run, ledger);
    if (shares) {
      chart('Overlap / smaller radius', '%', [{of: 'overlap', name: 'largest', values: shares.map(x => 100 * x)}]);
      used.add('penetration');
    }
    chart('Stress', 'Pa', ['stress_xx', 'stress_yy', 'stress_zz', 'stress_xy'], {shown: false});
  }
  // Everything else, by column; of several walls the same column together.
  const byName = new Map();
  for (const table of tables) {
    for (const name of Object.keys(table.columns)) {
      if (name === 'step' || name === 'time' || (table.file === 'ledger' && used.has(name))) continue;
      const key = `${table.file}/${name}`;
      if (!byName.has(key)) {
        byName.set(key, {title: nameAndUnit(name)[0], unit: table.units[name], shown: table.file === 'walls' && /^reaction/.test(name),
          time: table.columns.time, lines: [], thinned: table.allRows > table.rows});
      }
      byName.get(key).lines.push({name: table.part || nameAndUnit(name)[0], values: table.columns[name], time: table.columns.time});
    }
  }
  for (const [key, chart] of byName) {
    if (!chart.lines.some(varies)) continue;
    const taken = charts.some(other => other.title.toLowerCase() === chart.title.toLowerCase());
    if (taken) chart.title += ` (${key.split('/')[0]})`;
    charts.push(chart);
  }
  return charts;
}

/** The charts in the page. `jump(time)`: called when a reader points at a time. */
class CurvePanel {
  constructor(run, tables, jump) {
    this.run = run;
    this.jump = jump;
    this.charts = chartsOf(run, tables);
    this.plots = document.getElementById('plots');
    this.addChips();
    document.getElementById('csv').addEventListener('click', () => this.save());
    this.whole = document.getElementById('whole');
    this.whole.addEventListener('click', () => this.zoom(null));
    new ResizeObserver(() => this.resize()).observe(this.plots);
  }

  /** A button for each chart, which shows or hides it. */
  addChips() {
    document.getElementById('curves').hidden = !this.charts.length;
    document.getElementById('chips').replaceChildren(...this.charts.map(chart => {
      const chip = chart.chip = document.createElement('button');
      chip.type = 'button';
      chip.textContent = chart.title;
      chip.addEventListener('click', () => {
        chart.shown = !chart.shown;
        this.layOut();
      });
      return chip;
    }));
  }

  /** Takes later tables of the same run. */
  update(tables) {
    const before = this.charts, charts = chartsOf(this.run, tables);
    if (charts.length === before.length && charts.every((chart, k) => chart.title === before[k].title)) {
      before.forEach((chart, k) => {
        Object.assign(chart, {time: charts[k].time, lines: charts[k].lines, thinned: charts[k].thinned});
        chart.plot?.setData(dataOf(chart));
      });
      this.setTime(this.time ?? 0);
      return;
    }
    for (const chart of before) {
      if (chart.plot) chart.plot.destroy();
      const same = charts.find(({title}) => title === chart.title);
      if (same) same.shown ||= chart.shown;
    }
    this.charts = charts;
    this.addChips();
    this.layOut();
  }

  /** Makes the charts that are shown, in the colours of the theme. */
  layOut() {
    for (const chart of this.charts) {
      chart.chip.setAttribute('aria-pressed', chart.shown);
      if (chart.plot) chart.plot.destroy();
      chart.plot = null;
    }
    this.plots.replaceChildren();
    for (const chart of this.charts) if (chart.shown) this.make(chart);
    this.resize();
    this.setTime(this.time ?? 0);
  }

  make(chart) {
    const dark = document.documentElement.dataset.theme === 'dark';
    const colours = LINE_COLOURS[dark ? 'dark' : 'light'];
    const soft = dark ? '#9aa6ae' : '#5c6871', grid = dark ? '#262d31' : '#e8ecef';
    const place = document.createElement('div');
    place.className = 'plot';
    const head = document.createElement('h3');
    head.textContent = chart.title + (chart.unit ? ` [${chart.unit}]` : '');
    chart.values = chart.lines.map((line, k) => {
      const span = document.createElement('span'), mark = document.createElement('i'), text = document.createElement('b');
      mark.style.background = colours[k % colours.length];
      text.style.fontWeight = 400;
      span.append(mark, text);
      head.append(span);
      return text;
    });
    place.append(head);
    this.plots.append(place);
    const data = dataOf(chart);
    const series = [{}, ...chart.lines.map((line, k) => ({
      label: line.name, stroke: colours[k % colours.length], width: 1.5, spanGaps: true, points: {show: data[0].length < 3}
    }))];
    if (chart.level) {
      series.push({label: 'tolerance', stroke: dark ? '#ff9b92' : '#b3261e', width: 1.2, dash: [6, 4], points: {show: false}});
    }
    const axis = {stroke: soft, font: '12px system-ui, sans-serif', grid: {stroke: grid, width: 1}, ticks: {stroke: grid, width: 1, size: 4}};
    const anyValue = data[1].some(x => x !== null);
    chart.plot = new uPlot({
      width: 300, height: 168, legend: {show: false}, cursor: {sync: {key: 'run', setSeries: false}, drag: {x: true, y: false}, points: {size: 6}},
      scales: {x: {time: false, range: (u, low, high) => this.zoomed || [low, high > low ? high : low + 1]},
        y: chart.log && anyValue ? {distr: 3, range: (u, low, high) => logRange(low, high, chart.level)} : {range: (u, low, high) => low === null || low === undefined ? [0, 1]
          : uPlot.rangeNum(low, high > low ? high : low + (Math.abs(low) || 1) * 1e-3, 0.08, true)}},
      axes: [{...axis, size: 30, values: (u, ticks) => ticks.map(x => String(Number(x.toPrecision(6))))},
        {...axis, size: 62, ...(chart.log ? {filter: decades, grid: {...axis.grid, filter: decades}, ticks: {...axis.ticks, filter: decades}} : {}), values: (u, ticks) => ticks.map(x => x === null ? '' : chart.log ? power(Math.round(Math.log10(x))) : compact(x))}],
      series,
      hooks: {
        setScale: [() => this.place([chart])],
        setCursor: [u => this.showValues(chart, u.cursor.idx)],
        setSelect: [u => {
          if (u.select.width > 3) this.zoom([u.posToVal(u.select.left, 'x'), u.posToVal(u.select.left + u.select.width, 'x')]);
        }],
        ready: [u => {
          chart.now = document.createElement('div');
          chart.now.className = 'now';
          u.over.append(chart.now);
          this.place([chart]);
          let down = null;
          u.over.addEventListener('pointerdown', event => down = event.clientX);
          u.over.addEventListener('pointerup', event => {
            if (down !== null && Math.abs(event.clientX - down) < 4) this.jump(u.posToVal(event.clientX - u.over.getBoundingClientRect().left, 'x'));
            down = null;
          });
          u.over.addEventListener('dblclick', () => this.zoom(null));
        }]
      }
    }, data, place);
  }

  resize() {
    for (const chart of this.charts) {
      if (!chart.plot) continue;
      const width = chart.plot.root.parentElement.clientWidth - 12;
      if (width > 40 && width !== chart.plot.width) chart.plot.setSize({width, height: 168});
    }
    this.place();
  }
  /** Values at a row, or at the player's time. */
  showValues(chart, row) {
    if (!chart.values) return;
    const at = row ?? nearest(chart.time, this.time ?? 0);
    // Of a thinned table two rows have the extremes of many.
    const rows = chart.thinned ? [at - at % 2, at - at % 2 + 1] : [at];
    chart.lines.forEach((line, k) => {
      const texts = new Set(rows.map(at => chart.counts ? String(line.values[at]) : textOf(line.values[at])));
      const name = chart.lines.length > 1 || line.name !== chart.title ? line.name + ' ' : '';
      chart.values[k].textContent = name + [...texts].join(' … ');
    });
  }
  /** All charts show this stretch of time; null: the whole. */
  zoom(range) {
    this.zoomed = range;
    this.whole.hidden = !range;
    for (const {plot, time} of this.charts) {
      if (!plot) continue;
      plot.setSelect({left: 0, width: 0, top: 0, height: 0}, false);
      plot.setScale('x', range ? {min: range[0], max: range[1]} : {min: time[0], max: time.at(-1)});
    }
    this.place();
  }
  setTime(time) {
    this.time = time;
    this.place();
    for (const chart of this.charts) if (chart.plot && chart.plot.cursor.idx == null) this.showValues(chart, null);
  }
  /** Moves the bars to the player's time. */
  place(charts = this.charts) {
    for (const {plot, now} of charts) {
      if (!plot || !now) continue;
      const x = plot.valToPos(this.time ?? 0, 'x');
      now.hidden = !(x >= -1 && x <= plot.bbox.width / uPlot.pxRatio + 1);
      now.style.transform = `translateX(${x - 0.75}px)`;
    }
  }
  /** The charts that are shown as one CSV file: a time and a value column for each line. */
  save() {
    const shown = this.charts.filter(chart => chart.shown), columns = [];
    for (const chart of shown) {
      for (const line of chart.lines) {
        const unit = chart.unit ? ` [${chart.unit}]` : '';
        const extremes = chart.thinned ? ', extremes of several steps' : '';
        columns.push(['time [s]', line.time || chart.time], [`${chart.title}: ${line.name}${unit}${extremes}`, line.values]);
      }
    }
    const rows = Math.max(...columns.map(([, values]) => values.length));
    const lines = [columns.map(([name]) => `"${name}"`).join(',')];
    for (let k = 0; k < rows; ++k) lines.push(columns.map(([, values]) => k < values.length ? String(Number(values[k].toPrecision(8))) : '').join(','));
    download(new Blob([lines.join('\n') + '\n'], {type: 'text/csv'}), 'curves.csv');
  }
}

/** Columns for uPlot: time, lines, level. */
function dataOf(chart) {
  const columns = [Float64Array.from(chart.time)];
  for (const {values} of chart.lines) {
    columns.push(Array.from(values, x => Number.isFinite(x) && !(chart.log && x <= 0) ? x : null));
  }
  if (chart.level) columns.push(Array(columns[0].length).fill(chart.level));
  return columns;
}

/** Whole decades with the level; values far below it are of steps with little to do. */
function logRange(low, high, level) {
  if (low === null || low === undefined) return [level / 10, level * 10];
  const decade = (x, round) => 10 ** round(Math.log10(x));
  return [decade(Math.max(low, Math.min(level * 1e-5, high)), Math.floor), decade(Math.max(high, level * 1.5), Math.ceil)];
}
/** Keeps the marks of an axis at powers of ten, at most one in every second decade of many. */
function decades(u, marks) {
  const whole = marks.filter(x => Math.abs(Math.log10(x) - Math.round(Math.log10(x))) < 1e-6);
  const every = Math.ceil(whole.length / 6);
  return marks.map(x => {
    const at = whole.indexOf(x);
    return at >= 0 && (whole.length - 1 - at) % every === 0 ? x : null;
  });
}

/** Row of the value that is nearest; increasing values. */
function nearest(values, x) {
  let low = 0, high = values.length - 1;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] < x) low = middle + 1; else high = middle;
  }
  return low > 0 && x - values[low - 1] < values[low] - x ? low - 1 : low;
}
function compact(x) {
  if (x === 0) return '0';
  const size = Math.abs(x);
  const text = size >= 1e-3 && size < 1e5 ? String(Number(x.toPrecision(5))) : x.toExponential().replace('e+', 'e');
  return text.replaceAll('-', '−');
}
function download(blob, name) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 2000);
}
