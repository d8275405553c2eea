// Keyboard shortcuts, listed; the list can be clicked too.

// `actions`: [{key, name, run}], where run() returns whether it is on now, or nothing.
export function bindKeys(actions) {
  const list = document.getElementById("keys");
  const press = new Map();
  for (const {key, name, run, on} of actions) {
    const term = document.createElement("dt"), text = document.createElement("dd");
    term.textContent = key;
    text.textContent = name;
    const show = (state) => {
      if (typeof state === "string") text.textContent = state;
      else if (state !== undefined) text.setAttribute("aria-pressed", state);
    };
    show(on);
    const pressed = () => show(run());
    text.addEventListener("click", pressed);
    press.set(key.toLowerCase(), pressed);
    list.append(term, text);
  }
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    press.get(event.key.toLowerCase())?.();
  });
}
