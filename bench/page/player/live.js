// A run that goes on: the page asks its server for what is new (bench/page/watch_server.h).

/** Asks until the run is over or does not answer. */
async function follow(player) {
  const {about} = player.run;
  while (about.live) {
    try {
      const answer = await fetch(`update?after=${player.run.frames.at(-1).step}`);
      if (!answer.ok) throw new Error(await answer.text());
      await takeUpdate(player, await answer.json());
    } catch (failure) {
      about.live = false;
      about.lost = failure.message;
      player.showHead();
    }
  }
}

async function takeUpdate(player, update) {
  const {run, view} = player, {about} = run, {step} = player.frame;
  const atEnd = !player.playing && player.at === run.frames.length - 1;
  const tables = await readCurves(update, update.curve_data);
  const more = await readRun({...about, ...update}, update.frame_data);
  extendRun(run, more, update.steps);
  Object.assign(about, {marks: update.marks, summary: update.summary, live: !update.ended});
  const last = run.frames.length - 1, {time} = run.frames[last];
  if (!(time < 1.1 * player.measured)) {  // ranges and the box hold for all times
    player.measured = time;
    run.ranges = run.fullForce = undefined;
    view.box = view.wholeBox();
    if (!view.moved) view.fit();
    player.showLegend();
  }
  player.curves.update(tables);
  $('scrub').max = last;
  player.drawMarks();
  player.showHead();
  if (update.ended) fillFoot(run);
  player.go(atEnd ? last : Math.max(0, run.frames.findLastIndex(frame => frame.step <= step)));
}
