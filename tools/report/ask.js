// SPDX-License-Identifier: BSD-2-Clause
// Replaces cockpit/ask.js in a snapshot: returns what mlccad answered when the snapshot was made.
const cockpit = { hidden: true, addEventListener() {} };
const kLive = false;
const kSaid = JSON.parse(document.getElementById("snapshot").textContent);
const ask = async (verb, part) => kSaid[verb === "cluster" ? `cluster-${part}` : verb];
const follow = () => {}, followCounters = follow;
const admit = () => {}, changeMode = admit, reinstate = admit, release = admit, reload = admit, withdraw = admit;
