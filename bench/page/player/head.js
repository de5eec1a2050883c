// The head of the page: status, what was asked and reached, warnings; and what stands below.

function element(name, content, attributes = {}) {
  const made = Object.assign(document.createElement(name), attributes);
  made.append(...[content].flat());
  return made;
}

/** Largest overlap of each step over the smaller radius of the pair; of the smallest where runs of older versions say no more. */
function overlapShares(run, ledger) {
  const c = ledger?.columns;
  if (c?.overlap) return c.overlap;
  return c?.penetration && run.smallest < Infinity ? c.penetration.map(x => x / run.smallest) : null;
}

/** Step after which the summary counts: that of a restart, else 0. */
const summaryFrom = summary => summary ? Math.max(0, summary.last_step - summary.steps) : 0;

/** Warnings, the gravest first: {bad, text, time}. */
function warningsOf(run) {
  const {about} = run, {summary} = about, warnings = [];
  const unsolved = about.marks.filter(([kind]) => kind === 'unsolved');
  if (about.live) {
    // It has no summary yet.
  } else if (about.lost) {
    warnings.push({bad: true, text: `The run does not answer any more: ${about.lost}. What came before is shown.`});
  } else if (!summary) {
    const last = run.frames.at(-1);
    warnings.push({bad: true, text: `The run has not come to its end: there is no summary. Frames go to step ${last.step} of ${about.num_steps}. ` +
      `To go on: bipot run ${about.words.scene} --restart ${about.words.folder}`});
  } else if (!['completed', 'nothing to do', 'not converged'].includes(summary.status)) {
    warnings.push({bad: true, text: `${summary.status}: ${summary.message || `the run ended after step ${summary.last_step}`}`});
  }
  const earlier = unsolved.filter(([, step]) => step <= summaryFrom(summary)).length;
  const count = summary ? earlier + summary.steps - summary.steps_converged : unsolved.length;
  if (count > 0) {
    // The ledger may leave rows out, and the summary knows a last part alone.
    const steps = [unsolved[0]?.[1], summary?.first_unconverged_step].filter(step => step >= 0);
    const step = Math.min(...steps), first = unsolved.find(mark => mark[1] === step);
    warnings.push({bad: true, text: `${count} ${count === 1 ? 'step was' : 'steps were'} not solved to the tolerance ${textOf(about.tol, 1)}, first step ${step}` +
      (summary?.message && !warnings.length ? `; the worst: ${summary.message}` : ''), time: first ? first[2] : step * about.time_step});
  }
  const several = about.marks.filter(([kind]) => kind === 'several');
  if (several.length) {
    warnings.push({text: `${several.length} ${several.length === 1 ? 'step has' : 'steps have'} several exact answers; the run took one of them.`,
      time: several[0][2]});
  }
  const deep = about.marks.filter(([kind]) => kind === 'overlap'), most = summary?.overlap;
  if (most?.largest > most?.beyond) deep.push(['overlap', most.step, most.step * about.time_step, most.largest]);
  deep.sort((a, b) => b[3] - a[3]);
  for (const [, step, time, share] of deep.slice(0, 1)) {
    warnings.push({text: `Bodies overlap by up to ${textOf(100 * share, 3)} % of the smaller radius (step ${step}). ` +
      'A smaller time step makes it smaller.', time});
  }
  for (const text of about.notes) warnings.push({text});
  return warnings;
}

function fillHead(run, jump) {
  const {about} = run, {summary} = about, last = run.frames.at(-1);
  const state = about.live ? 'running' : summary ? summary.status : 'no summary';
  const good = ['completed', 'nothing to do', 'running'].includes(state);
  const facts = [element('span', state, {className: `chip ${good ? 'good' : 'bad'}`})];
  const fact = text => facts.push(element('span', text));
  const from = summaryFrom(summary), since = from > 0 ? ` since step ${from}` : '';
  fact(summary ? `${summary.steps} of ${summary.steps_planned} steps${since}, to t = ${textOf(summary.time, 4)} s` : `step ${last.step} of ${about.num_steps}, t = ${textOf(last.time, 4)} s`);
  fact(`${last.count} ${run.dim === 2 ? 'disk' : 'sphere'}${last.count === 1 ? '' : 's'}`);
  if (summary?.accuracy) {
    const {asked, parts, rejected, smallest_part, misplaced} = summary.accuracy;
    const again = Object.values(rejected).reduce((sum, n) => sum + n, 0);
    fact(`accuracy ${asked} radii: ${parts} parts, ${again} rejected, the smallest ${textOf(smallest_part, 2)} s; impacts misplaced by at most ${textOf(misplaced, 2)} radii`);
  }
  if (about.model === 'dem') fact('springs and dashpots');
  else {
    fact(`asked: ${about.solver} to ${textOf(about.tol, 1)}`);
    if (summary && Number.isFinite(summary.epsilon ?? NaN)) {
      fact(`reached: max(ε, η) ${textOf(Math.max(summary.epsilon, summary.eta ?? 0), 2)} at worst${since}, step ${summary.worst_step}`);
    }
  }
  if (summary?.seconds) fact(`computed in ${textOf(summary.seconds.total, 2)} s${since}`);
  document.getElementById('status').replaceChildren(...facts);
  const list = warningsOf(run).map(({bad, text, time}) => {
    const item = element('li', text, {className: bad ? 'bad' : ''});
    if (time !== undefined) {
      const link = element('a', `Show t = ${textOf(time, 4)} s`, {href: `#t=${Number(time.toPrecision(7))}`});
      link.addEventListener('click', event => { event.preventDefault(); jump(time); });
      item.append(' ', link);
    }
    return item;
  });
  document.getElementById('warnings').replaceChildren(...list);
  document.title = `${about.title} · Bipot`;
}

/** Scene file, origin, keys, and the next commands. */
function fillFoot(run) {
  const {about} = run, {summary} = about, {scene, folder} = about.words;
  const known = rows => element('dl', rows.filter(([, value]) => value !== undefined && value !== '')
    .flatMap(([name, value]) => [element('dt', name), element('dd', String(value))]));
  const fold = (title, content, open = false) => element('details', [element('summary', title), ...[content].flat()], {open});
  const left = about.num_steps - run.frames.at(-1).step;
  // The command of the run with its flags, but for those that a restart replaces.
  const again = (summary?.command_line || `bipot run ${scene}`).replace(
    / --(restart|steps|duration|out|json|time-limit|port)(=| )((?:'[^']*'|\\.|[^\s'\\])+)| --(overwrite|watch)\b/g, '');
  const next = [`${again} --restart ${folder} --steps ${left > 0 ? left : Math.max(100, Math.round(about.num_steps / 4))}`,
    `bipot advise ${scene}`, `paraview ${folder}/run.xdmf`];
  const keys = [['Space', 'play, pause'], ['← →', 'one frame; with Shift ten'], ['Home End', 'first, last frame'], ['+ −', 'closer, farther; also the wheel or two fingers'],
    ['F', 'fit'], ['Esc', 'let go of the body'], [run.dim === 2 ? 'Drag' : 'Drag, Shift and drag', run.dim === 2 ? 'move the picture' : 'turn, move the picture']];
  document.getElementById('about-run').replaceChildren(
    fold('What to do next', element('pre', next.join('\n')), true),
    fold('Scene file', element('pre', about.scene || '(none)')),
    fold('How this was made', known([
      ['command', summary?.command_line || `bipot run ${scene}`], ['program', `bipot ${about.version}, page by commit ${about.commit}`],
      ['time step', `${textOf(about.time_step)} s`], ['frames', `${run.frames.length}, steps ${run.frames[0].step} to ${run.frames.at(-1).step}`],
      ['numbers', `positions to ${textOf(about.quantum / 2, 2)} m, velocities and forces to 0.11 %; files of the run have all digits`],
      ['processes', summary?.processes], ['state', summary?.state]])),
    fold('Keys', element('dl', keys.flatMap(([key, what]) => [element('dt', element('kbd', key)), element('dd', what)]))));
}
