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

/** Calls `on` with each event, `state` with whether they come. */
export function follow(on, state) {
  let rest = "";
  state(true);
  cockpit.spawn(["mlccactl", "--json", "monitor"], { err: "message" })
    .stream((data) => {
      const lines = (rest + data).split("\n");
      rest = lines.pop();
      for (const line of lines) {
        const event = JSON.parse(line);
        if (event.kind) on(event);
      }
    })
    .then(() => {}, () => {})
    .finally(() => {
      state(false);
      setTimeout(() => follow(on, state), kPause);
    });
}
