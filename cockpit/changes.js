// SPDX-License-Identifier: BSD-2-Clause
// Dialogs for changes of the gateway. The user confirms a change, and mlccactl makes it as an administrator.
import { change, ask } from "./ask.js";
import { by, h } from "./dom.js";

/** Shows a form. `run(form)` returns the text to show at the end, or throws. */
function form(title, content, label, run, dangerous) {
  const dialog = by("dialog");
  const said = h("p", { class: "answer", role: "status" });
  const go = h("button", { type: "submit", class: dangerous ? "danger" : "primary" }, label);
  const element = h("form", { method: "dialog", onsubmit: async (e) => {
    e.preventDefault();
    go.disabled = true;
    said.textContent = "…";
    try {
      said.textContent = await run(new FormData(element), said);
      if (!said.textContent) dialog.close();
    } catch (problem) {
      said.textContent = problem.message;
    }
    go.disabled = false;
  } }, h("h2", { id: "dialog-title" }, title), content, said,
  h("div", { class: "buttons" }, go, h("button", { type: "button", onclick: () => dialog.close() }, "Close")));
  dialog.replaceChildren(element);
  dialog.showModal();
}

const field = (name, label, more = {}) => h("label", {}, label, h("input", { name, autocomplete: "off", ...more }));

export function changeMode(mode) {
  const to = mode === "audit" ? "enforce" : "audit";
  const what = h("p", {}, to === "audit"
    ? "In audit mode nothing is dropped: data that was not admitted passes, and is counted."
    : "What is not admitted is dropped, from now on or from when nothing would have been dropped for some time.");
  const later = field("clean", "Only after so long without a drop, such as 24h; empty: now");
  form(`Change to ${to} mode`, to === "audit" ? what : [what, later], `Change to ${to}`, async (data) => {
    const when = data.get("clean");
    const done = await change("mode", to, ...(when ? ["--when-clean", when] : []));
    return when ? done.message : "";
  }, to === "audit");
}

export function withdraw(name) {
  form(`Withdraw ${name}`, h("p", {}, "All of this channel is refused until it is reinstated, what is described too."),
    "Withdraw", async () => { await change("withdraw", "--yes", "--", name); return ""; }, true);
}
export const reinstate = (name) => form(`Reinstate ${name}`, h("p", {}, "It is decided again."), "Reinstate",
  async () => { await change("reinstate", "--", name); return ""; });
export const release = (c) => form(`Release admission ${c.admission}`,
  h("p", {}, `${c.name} of ${c.publisher} to ${c.to} ends.`), "Release",
  async () => { await change("release", "--id", String(c.admission)); return ""; }, true);
export const reload = () => form("Read the description again", h("p", {}, "All of it, or nothing where it has an error."),
  "Reload", async () => (await change("reload")).message);

/** Shows what would be decided, and then admits. */
export function admit(channels, places) {
  const lists = [["names", channels], ["places", places]].map(([id, all]) =>
    h("datalist", { id }, [...new Set(all)].map((value) => h("option", { value }))));
  form("Admit a publisher or subscriber", [...lists,
    field("channel", "Channel", { required: true, list: "names" }),
    field("from", "New publisher at network or gateway", { list: "places" }),
    field("to", "New subscriber at network or gateway", { list: "places" }),
    field("user", "User of a program on this gateway that publishes"),
    h("label", { class: "tick" }, h("input", { type: "checkbox", name: "only", checked: true }), "Only ask whether it would be admitted")],
  "Go on", async (data) => {
    const words = [data.get("channel")];
    for (const name of ["from", "to", "user"]) if (data.get(name)) words.push(`--${name}=${data.get(name)}`);
    const answer = data.get("only") ? await ask("query", ...words) : await change("admit", ...words);
    return answer.channels.map((c) => `${data.get("only") ? (c.granted ? "would be granted" : "would be refused")
      : c.granted ? "granted" : "refused"}, ${c.from} to ${c.to}: ${c.reason}`).join("\n");
  });
}
