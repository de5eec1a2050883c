// The player: time, controls, pointer, keys, and what the pointer stands on.

const FRAMES_A_SECOND = 30, SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];
const $ = id => document.getElementById(id);

class Player {
  constructor(run, view, curves) {
    Object.assign(this, {run, view, curves});
    this.at = 0;
    this.speed = 1;
    this.look = {colour: 'speed', chains: true, open: run.dim === 2, arrows: false, spokes: run.dim === 2 && run.radius.length <= 40, walls: true,
      centred: false, spheres: run.dim === 3 ? 'glass' : 'solid', cutAxis: -1, cutAt: 0, picked: null, colours: null};
    this.addControls();
    this.addPointer();
    this.addKeys();
  }

  get frame() { return this.run.frames[this.at]; }

  redraw() {
    if (this.due) return;
    this.due = true;
    requestAnimationFrame(() => {
      this.due = false;
      this.draw();
    });
  }
  draw() {
    const {width, height} = this.view.size();
    if (!width || !height) return;  // a window opened behind others: its size comes later
    this.view.draw(this.frame, this.look);
    this.showScale();
  }

  /** Shows a frame, and its time wherever time stands. */
  go(at) {
    this.at = Math.min(this.run.frames.length - 1, Math.max(0, at));
    const {frame} = this;
    $('scrub').value = this.at;
    $('clock').textContent = `t = ${textOf(frame.time, 4)} s · step ${frame.step} · frame ${this.at + 1} of ${this.run.frames.length}`;
    this.curves.setTime(frame.time);
    this.showPicked();
    this.redraw();
  }
  goToTime(time) {
    let best = 0;
    this.run.frames.forEach((frame, k) => {
      if (Math.abs(frame.time - time) < Math.abs(this.run.frames[best].time - time)) best = k;
    });
    this.pause();
    this.go(best);
    this.writeLink();
  }

  play() {
    if (this.playing) return;
    if (this.at === this.run.frames.length - 1) this.go(0);
    this.playing = true;
    $('play').classList.add('on');
    $('play').ariaLabel = 'Pause';
    let last = performance.now(), due = 0;
    const tick = now => {
      if (!this.playing) return;
      due += (now - last) / 1000 * FRAMES_A_SECOND * this.speed;
      last = now;
      const whole = Math.min(Math.floor(due), 8);  // a slow machine leaves frames out
      due -= Math.floor(due);
      if (whole > 0) this.go(this.at + whole);
      if (this.at === this.run.frames.length - 1 && !this.run.about.live) this.pause();
      else requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }
  pause() {
    if (!this.playing) return;
    this.playing = false;
    $('play').classList.remove('on');
    $('play').ariaLabel = 'Play';
    this.writeLink();
  }
  writeLink() {
    const hash = `#t=${Number(this.frame.time.toPrecision(7))}`;
    try {
      history.replaceState(null, '', hash);
    } catch {
      location.hash = hash;
    }
  }
  readLink() {
    const found = /^#t=([-+.\deE]+)$/.exec(location.hash);
    if (found && Number.isFinite(Number(found[1]))) this.goToTime(Number(found[1]));
    return Boolean(found);
  }

  addControls() {
    const {run, look} = this;
    const on = (id, what) => $(id).addEventListener('click', what);
    on('first', () => { this.pause(); this.go(0); this.writeLink(); });
    on('last', () => { this.pause(); this.go(run.frames.length - 1); this.writeLink(); });
    on('back', () => { this.pause(); this.go(this.at - 1); this.writeLink(); });
    on('ahead', () => { this.pause(); this.go(this.at + 1); this.writeLink(); });
    on('play', () => this.playing ? this.pause() : this.play());
    on('fit', () => { this.view.fit(); this.redraw(); });
    on('closer', () => { this.view.zoom(1.3); this.redraw(); });
    on('farther', () => { this.view.zoom(1 / 1.3); this.redraw(); });
    on('picture', () => this.savePicture());
    on('link', () => this.copyLink());
    on('theme', () => this.setTheme(document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark'));
    $('scrub').max = run.frames.length - 1;
    $('scrub').addEventListener('input', () => { this.pause(); this.go(Number($('scrub').value)); });
    $('scrub').addEventListener('change', () => this.writeLink());
    for (const speed of SPEEDS) $('speed').append(element('option', `${speed} ×`, {value: speed, selected: speed === 1}));
    $('speed').title = `× ${FRAMES_A_SECOND} frames a second`;
    $('speed').addEventListener('change', () => this.speed = Number($('speed').value));
    for (const name of usefulQuantities(run)) {
      const {label, unit} = QUANTITIES[name];
      $('colour').append(element('option', (label || name) + (unit ? ` [${unit}]` : ''), {value: name}));
    }
    $('colour').value = look.colour;
    $('colour').addEventListener('change', () => { look.colour = $('colour').value; this.showLegend(); this.redraw(); });
    const check = (key, text) => {
      const box = element('input', [], {type: 'checkbox', checked: look[key], id: `check-${key}`});
      box.addEventListener('change', () => {
        look[key] = box.checked;
        if (key === 'chains' && run.dim === 3 && look.spheres === (box.checked ? 'solid' : 'glass')) {
          look.spheres = $('spheres').value = box.checked ? 'glass' : 'solid';  // chains run inside the spheres
        }
        this.showLegend();
        this.redraw();
      });
      $('checks').append(element('label', [box, text]));
    };
    check('chains', 'Force chains');
    check('open', 'Open contacts');
    check('arrows', 'Velocities');
    check('spokes', run.dim === 2 ? 'Spokes' : 'Rotation pattern');
    check('walls', 'Walls');
    if (run.dim === 3) {
      $('space-tools').hidden = false;
      $('spheres').value = look.spheres;
      $('spheres').addEventListener('change', () => { look.spheres = $('spheres').value; this.redraw(); });
      const cut = () => {
        look.cutAxis = $('cut-axis').value === '' ? -1 : Number($('cut-axis').value);
        $('cut').disabled = look.cutAxis < 0;
        const {lower, upper} = this.view.box, share = $('cut').value / 1000;
        if (look.cutAxis >= 0) look.cutAt = lower[look.cutAxis] + share * (upper[look.cutAxis] - lower[look.cutAxis]);
        this.redraw();
      };
      $('cut-axis').addEventListener('change', cut);
      $('cut').addEventListener('input', cut);
      cut();
    }
    new ResizeObserver(() => {
      const before = this.view.fitted, scale = this.view.scale;
      this.view.resize();
      if (before === undefined || before === scale || run.dim === 3) this.view.fit();
      this.drawMarks();
      this.draw();  // at once: the canvas is empty after a change of its size
    }).observe($('stage'));
    window.addEventListener('hashchange', () => this.readLink());
    let theme;
    window.addEventListener('beforeprint', () => {
      theme = document.documentElement.dataset.theme;
      this.setTheme('light');
      this.draw();  // at once: the paper does not wait
    });
    window.addEventListener('afterprint', () => this.setTheme(theme));
  }

  addPointer() {
    const stage = $('stage'), fingers = new Map();
    let moved = 0, turning = false;
    const place = event => {
      const box = stage.getBoundingClientRect();
      return [event.clientX - box.left - 1, event.clientY - box.top - 1];
    };
    stage.addEventListener('contextmenu', event => event.preventDefault());
    stage.addEventListener('pointerdown', event => {
      stage.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, place(event));
      turning = event.button === 0 && !event.shiftKey;
      if (fingers.size === 1) moved = 0;
      stage.classList.add('dragging');
    });
    stage.addEventListener('pointermove', event => {
      const now = place(event), before = fingers.get(event.pointerId);
      if (!before) return this.hover(...now);
      const dx = now[0] - before[0], dy = now[1] - before[1];
      moved += Math.abs(dx) + Math.abs(dy);
      if (fingers.size === 1) {
        if (moved > 4) turning ? this.view.turn(dx, dy) : this.view.drag(dx, dy);
      } else if (fingers.size === 2) {
        const other = [...fingers].find(([id]) => id !== event.pointerId)[1];
        const apart = ([x, y]) => Math.hypot(x - other[0], y - other[1]);
        this.view.drag(dx / 2, dy / 2);
        this.view.zoom(apart(now) / Math.max(1, apart(before)), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
      }
      fingers.set(event.pointerId, now);
      this.redraw();
    });
    const up = event => {
      if (!fingers.delete(event.pointerId)) return;
      if (!fingers.size) stage.classList.remove('dragging');
      if (event.type === 'pointerup' && moved <= 4 && !fingers.size) this.pick(...place(event));
    };
    stage.addEventListener('pointerup', up);
    stage.addEventListener('pointercancel', up);
    stage.addEventListener('pointerleave', () => $('tip').hidden = true);
    stage.addEventListener('wheel', event => {
      event.preventDefault();
      this.view.zoom(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0016)), ...place(event));
      this.redraw();
    }, {passive: false});
  }

  addKeys() {
    window.addEventListener('keydown', event => {
      if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest?.('select, input[type=checkbox]')) return;
      const step = event.shiftKey ? 10 : 1;
      const act = {
        ' ': () => this.playing ? this.pause() : this.play(),
        ArrowLeft: () => { this.pause(); this.go(this.at - step); this.writeLink(); },
        ArrowRight: () => { this.pause(); this.go(this.at + step); this.writeLink(); },
        Home: () => { this.pause(); this.go(0); this.writeLink(); },
        End: () => { this.pause(); this.go(this.run.frames.length - 1); this.writeLink(); },
        '+': () => { this.view.zoom(1.25); this.redraw(); },
        '=': () => { this.view.zoom(1.25); this.redraw(); },
        '-': () => { this.view.zoom(0.8); this.redraw(); },
        f: () => { this.view.fit(); this.redraw(); },
        Escape: () => this.letGo()
      }[event.key];
      if (!act || (event.key === ' ' && event.target.closest?.('button, summary'))) return;
      event.preventDefault();
      act();
    });
  }

  /** Rows of text on a body or contact. */
  facts(picked) {
    const {run, frame} = this, D = run.dim;
    const vector = (x, unit) => `(${x.map(c => textOf(c)).join(', ')}) ${unit}`;
    if (picked.body !== undefined) {
      const k = indexOf(frame, picked.body), b = picked.body;
      if (k < 0) return {title: `Body ${b}`, rows: [['', 'is not there at this time']]};
      const v = logsOf(frame.v, frame.count, k), spin = logsOf(frame.spin, frame.count, k), force = resultant(run, frame, b);
      let contacts = 0, pushing = 0;
      for (let c = 0; c < frame.contacts; ++c) {
        if (frame.i[c] !== b && frame.j[c] !== b) continue;
        ++contacts;
        if (carries(frame, c)) ++pushing;
      }
      const rows = [['place', vector(placeOf(run, frame, k).map((x, c) => x + run.about.origin[c]), 'm')], ['radius', `${textOf(run.radius[b], 4)} m`],
        ['mass', run.cluster[b] >= 0 ? `of cluster ${run.cluster[b]}` : run.glued[b] ? 'of its wall' : `${textOf(run.mass[b], 4)} kg`], ['speed', `${textOf(Math.hypot(...v))} m/s`],
        ['velocity', vector(v, 'm/s')], ['spin', D === 2 ? `${textOf(spin[0])} rad/s` : vector(spin, 'rad/s')],
        ['contacts', `${contacts}, ${pushing} with a force`], ['contact force', vector(force, 'N')], ['its size', `${textOf(Math.hypot(...force))} N`]];
      if (run.about.materials.length > 1) rows.push(['material', run.about.materials[run.material[b]]]);
      return {title: `${D === 2 ? 'Disk' : 'Sphere'} ${b}`, rows};
    }
    const k = contactIndex(frame, picked);
    const other = picked.j >= WALL ? `wall ${run.about.walls[picked.j - WALL].name || picked.j - WALL}` : String(picked.j);
    if (k < 0) return {title: `Contact ${picked.i} – ${other}`, rows: [['', 'is not there at this time']]};
    const ft = logsOf(frame.ft, frame.contacts, k), fn = LOG[frame.fn[k]], size = Math.hypot(...ft);
    return {title: `Contact ${picked.i} – ${other}`, rows: [['gap', `${textOf(LOG[frame.gap[k]])} m`], ['normal force', `${textOf(fn)} N`],
      ['tangential', D === 2 ? `${textOf(ft[0])} N` : `${textOf(size)} N`], ['ratio', fn > 0 ? textOf(size / fn) : '–'],
      ['status', ['opens', 'sticks', 'slips'][frame.status[k]]], ['normal', vector(normalOf(run, frame, k), '')]]};
  }
  table({rows}) {
    return element('table', element('tbody', rows.map(([name, value]) => element('tr', [element('td', name), element('td', value)]))));
  }
  hover(px, py) {
    const tip = $('tip'), found = this.view.pick(this.frame, this.look, px, py);
    tip.hidden = !found;
    if (!found) return;
    const facts = this.facts(found);
    const brief = facts.rows.filter(([name]) => !['velocity', 'place', 'normal', 'its size', 'material'].includes(name));
    tip.replaceChildren(element('b', facts.title), ...brief.map(([name, value]) => element('div', `${name} ${value}`)));
    const {width, height} = this.view.size(), box = tip.getBoundingClientRect();
    tip.style.left = `${Math.max(4, px + 16 + box.width < width ? px + 16 : px - box.width - 12)}px`;
    tip.style.top = `${Math.max(4, Math.min(py + 12, height - box.height - 6))}px`;
  }
  pick(px, py) {
    this.look.picked = this.view.pick(this.frame, this.look, px, py);
    $('tip').hidden = true;
    this.showPicked();
    this.redraw();
  }
  letGo() {
    this.look.picked = null;
    this.showPicked();
    this.redraw();
  }
  showPicked() {
    const {picked} = this.look;
    if (!picked) {
      if (this.pickedShown) $('picked').replaceChildren(element('p', 'Rest the pointer on a body or a contact. Click a body to follow it.', {className: 'soft'}));
      this.pickedShown = false;
      return;
    }
    this.pickedShown = true;
    const facts = this.facts(picked), close = element('button', 'let go', {type: 'button'});
    close.addEventListener('click', () => this.letGo());
    const shown = [element('h3', [facts.title, close]), this.table(facts)];
    if (picked.body !== undefined) {
      const middle = element('input', [], {type: 'checkbox', checked: this.look.centred});
      middle.addEventListener('change', () => { this.look.centred = middle.checked; this.redraw(); });
      shown.push(element('label', [middle, 'Keep it in the middle'], {className: 'follow'}));
    }
    $('picked').replaceChildren(...shown);
  }

  showLegend() {
    const {run, look} = this, quantity = QUANTITIES[look.colour], {colours} = look, parts = [];
    const name = quantity.label || look.colour;
    if (quantity.kinds) {
      const names = look.colour === 'material' ? run.about.materials : [];
      parts.push(...names.map((text, k) => {
        const mark = element('i', [], {className: 'box', inks: [cssOf(colours.kinds[k % colours.kinds.length])]});
        mark.style.background = cssOf(colours.kinds[k % colours.kinds.length]);
        return element('span', [mark, text || `material ${k}`], {className: 'key'});
      }));
    } else if (!quantity.plain) {
      const [low, high] = rangeOf(run, look.colour);
      const list = quantity.cyclic ? colours.cyclic : quantity.both && run.dim === 2 ? colours.both : colours.rising;
      const bar = element('i', [], {inks: list.map(cssOf)});
      bar.style.background = `linear-gradient(90deg, ${list.map(cssOf).join(', ')})`;
      const number = x => quantity.whole ? String(x) : textOf(x);
      parts.push(element('span', [element('span', `${name} ${number(low)}${low < 0 ? ' or less' : ''}`), bar,
        element('span', `${number(high)} ${quantity.unit}${quantity.cyclic || look.colour === 'mass' ? '' : ' or more'}`)], {className: 'ramp'}));
    }
    if (look.chains) {
      const key = (colour, text, dots) => {
        const mark = element('i', [], {className: dots ? 'dots' : '', inks: [colour]});
        mark.style.borderColor = colour;
        return element('span', [mark, text], {className: 'key'});
      };
      parts.push(key(colours.stick, 'sticks'), key(colours.slip, 'slips'));
      run.tension ??= run.frames.some(f => f.fn.some(code => LOG[code] < 0));
      if (run.tension) parts.push(key(colours.tension, 'tension'));
      if (look.open) parts.push(key(colours.open, 'opens', true));
      parts.push(element('span', `full width ${textOf(fullForce(run))} N or more`, {className: 'soft'}));
    }
    $('legend').replaceChildren(...parts);
  }
  showHead() {
    fillHead(this.run, time => this.goToTime(time));
  }
  /** A bar of a round length. */
  showScale() {
    const scale = this.view.lengthScale(), wanted = 110 / scale;
    const power = 10 ** Math.floor(Math.log10(wanted)), length = [5, 2, 1].find(x => x * power <= wanted) * power;
    const bar = $('scale');
    bar.firstElementChild.style.width = `${length * scale}px`;
    const units = [[1e3, 'km'], [1, 'm'], [1e-2, 'cm'], [1e-3, 'mm'], [1e-6, 'µm']];
    const [size, unit] = units.find(([value]) => length >= value * 0.999) || [1, 'm'];
    bar.lastElementChild.textContent = size === 1 && unit === 'm' && length < 1e-6 ? `${textOf(length, 1)} m` : `${Number((length / size).toPrecision(3))} ${unit}`;
  }

  /** Steps that were not solved, cut, or have several answers, over the slider. */
  drawMarks() {
    const canvas = $('marks'), {run} = this, ratio = Math.min(window.devicePixelRatio || 1, 2);
    const width = canvas.clientWidth, height = canvas.clientHeight, pen = canvas.getContext('2d');
    canvas.width = width * ratio;
    canvas.height = height * ratio;
    pen.scale(ratio, ratio);
    const steps = run.frames.map(frame => frame.step), thumb = 8;
    const colours = {unsolved: this.look.colours.dark ? '#ff9b92' : '#b3261e', several: this.look.colours.inlet};
    for (const [kind, step] of run.about.marks) {
      const after = steps.findIndex(s => s >= step);
      if (after < 0 || !colours[kind]) continue;
      const share = after ? (after - (steps[after] - step) / (steps[after] - steps[after - 1])) / (steps.length - 1) : 0;
      pen.fillStyle = colours[kind];
      pen.fillRect(thumb + share * (width - 2 * thumb) - 1, 0, 2, 7);
    }
  }

  setTheme(theme) {
    document.documentElement.dataset.theme = theme;
    $('theme').textContent = theme === 'dark' ? 'Light' : 'Dark';
    this.look.colours = palette(theme === 'dark');
    this.showLegend();
    this.drawMarks();
    this.curves.layOut();
    this.redraw();
  }

  /** The view as PNG, with title, time and legend below. */
  async savePicture() {
    const {canvas} = this.view, {colours} = this.look, ratio = this.view.ratio;
    this.view.draw(this.frame, this.look);
    const whole = document.createElement('canvas');
    whole.width = canvas.width;
    whole.height = canvas.height + Math.round(52 * ratio);
    const pen = whole.getContext('2d');
    pen.fillStyle = colours.stage;
    pen.fillRect(0, 0, whole.width, whole.height);
    pen.drawImage(canvas, 0, 0);
    pen.scale(ratio, ratio);
    pen.translate(0, canvas.height / ratio);
    pen.fillStyle = colours.ink;
    pen.font = '600 13px system-ui, sans-serif';
    pen.fillText(`${this.run.about.title} · t = ${textOf(this.frame.time, 4)} s · step ${this.frame.step}`, 12, 18);
    pen.font = '12px system-ui, sans-serif';
    this.drawLegend(pen, 12, 38);
    const blob = await new Promise(done => whole.toBlob(done, 'image/png'));
    download(blob, `step_${String(this.frame.step).padStart(6, '0')}.png`);
  }
  /** The legend and the scale of lengths, from a point on the base line on. */
  drawLegend(pen, x, y) {
    const write = text => {
      pen.fillStyle = this.look.colours.ink;
      pen.fillText(text, x, y);
      x += pen.measureText(text).width + 6;
    };
    const bar = (inks, width) => {
      const ramp = pen.createLinearGradient(x, 0, x + width, 0);
      inks.forEach((ink, k) => ramp.addColorStop(k / Math.max(1, inks.length - 1), ink));
      pen.fillStyle = ramp;
      pen.fillRect(x, y - 8, width, 8);
      x += width + 6;
    };
    for (const part of $('legend').children) {
      for (const piece of part.childNodes) piece.inks ? bar(piece.inks, piece.inks.length > 1 ? 70 : 16) : write(piece.textContent);
      x += 8;
    }
    const [line, length] = $('scale').children;
    bar([this.look.colours.ink], parseFloat(line.style.width));
    write(length.textContent);
  }
  async copyLink() {
    this.writeLink();
    const say = text => {
      $('link').textContent = text;
      setTimeout(() => $('link').textContent = 'Link', 1500);
    };
    try {
      await navigator.clipboard.writeText(location.href);
      say('copied');
    } catch {
      say('see address');  // pages from files may not write to the clipboard
    }
  }
}

async function start() {
  const about = JSON.parse($('about').textContent);
  try {
    const run = await readRun(about, $('frame-data').textContent, share => $('loading').textContent = `Reading the frames … ${Math.round(100 * share)} %`);
    const tables = await readCurves(about, $('curve-data').textContent);
    let player;
    const curves = new CurvePanel(run, tables, time => player.goToTime(time));
    $('loading').hidden = true;
    const view = run.dim === 2 ? new PlaneView($('view'), run) : new SpaceView($('view'), run);
    view.resize();
    view.fit();
    player = new Player(run, view, curves);
    player.showHead();
    fillFoot(run);
    const asked = window.matchMedia('(prefers-color-scheme: dark)');
    player.setTheme(asked.matches ? 'dark' : 'light');
    asked.addEventListener('change', () => player.setTheme(asked.matches ? 'dark' : 'light'));
    if (!player.readLink()) player.go(run.frames.length - 1);
    window.bipotPlayer = player;  // for tests and the console
    if (about.live) follow(player);
  } catch (failure) {
    $('loading').hidden = false;
    $('loading').textContent = `The page cannot show this run: ${failure.message}`;
    throw failure;
  }
}
start();
