// SPDX-License-Identifier: BSD-2-Clause
// The bridge: mlccactl, which speaks JSON.
/* global cockpit */

/** Not so in a snapshot (tools/report). */
export const kLive = true;
const kPause = 2000; // ms until a monitor that ended is started again

async function run(words, options) {
  const text = await cockpit.spawn(["mlccactl", "--json", ...words], { err: "message", ...options })
    .catch((problem, data) => {
      // Refusals and errors are answers, too: with a status, and on standard output.
      if (data && data.startsWith("{")) return data;
      throw new Error(problem.problem === "not-found" ? "mlccactl is not installed"
        : problem.problem === "access-denied" ? "this needs administrative access" : problem.message);
    });
  const answer = JSON.parse(text);
  if (answer.error) throw new Error([answer.error.message, ...(answer.error.details ?? [])].join("\n"));
  return answer;
}

export const ask = (...words) => run(words, {});
/** As an administrator: Cockpit asks for the password where it has to. */
export const change = (...words) => run(words, { superuser: "require" });

/** Calls `on` with each object that a program prints on a line of its own, and `ended` when it ends. */
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

/** Calls `on` with each event, `state` with whether they come. */
export function follow(on, state) {
  state(true);
  lines(["monitor"], (event) => { if (event.kind) on(event); }, () => {
    state(false);
    setTimeout(() => follow(on, state), kPause);
  });
}

/** Calls `on` once a second with what has changed of the counters, while the page can be seen, and `lost` when that ends. */
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
