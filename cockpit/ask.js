// SPDX-License-Identifier: BSD-2-Clause
// Requests to mlccad, by way of `mlccactl --json`.
/* global cockpit */

/** False in a snapshot (tools/report). */
export const kLive = true;
const kPause = 2000; // ms until a monitor that ended is started again

async function run(words, options) {
  const text = await cockpit.spawn(["mlccactl", "--json", ...words], { err: "message", ...options })
    .catch((problem, data) => {
      // Refusals and errors are answers as well, with an exit status and on standard output.
      if (data && data.startsWith("{")) return data;
      throw new Error(problem.problem === "not-found" ? "mlccactl is not installed"
        : problem.problem === "access-denied" ? "this needs administrative access" : problem.message);
    });
  const answer = JSON.parse(text);
  if (answer.error) throw new Error([answer.error.message, ...(answer.error.details ?? [])].join("\n"));
  return answer;
}

export const ask = (...words) => run(words, {});
/** Runs as an administrator. Cockpit asks for the password if that is necessary. */
export const change = (...words) => run(words, { superuser: "require" });

/** Calls `on` with each object that mlccactl prints, one on each line, and `ended` when it ends. */
function lines(words, on, ended) {
  let rest = "";
  const process = cockpit.spawn(["mlccactl", "--json", ...words], { err: "message" });
  process.stream((data) => {
    const all = (rest + data).split("\n");
    rest = all.pop();
    for (const line of all) on(JSON.parse(line));
  }).then(() => {}, () => {}).finally(ended);
  return process;
}

/** Calls `on` with each event, and `state` with whether events are received. */
export function follow(on, state) {
  state(true);
  lines(["monitor"], (event) => { if (event.kind) on(event); }, () => {
    state(false);
    setTimeout(() => follow(on, state), kPause);
  });
}

/** Calls `on` once a second with the changed counters while the page is visible, and `lost` when that ends. */
export function followCounters(on, lost) {
  let process = null;
  const run = () => {
    if (process || cockpit.hidden) return;
    process = lines(["top"], (line) => { if (line.counters) on(line); }, () => {
      process = null;
      lost();
      setTimeout(run, kPause);
    });
  };
  cockpit.addEventListener("visibilitychange", () => {
    if (cockpit.hidden) process?.close("cancelled");
    else run();
  });
  run();
}
