// Small helpers around the elements of index.html.

/** The element with this id; a missing one is a mistake in index.html. */
export function byId(id) {
  const found = document.getElementById(id);
  if (!found) throw new Error(`index.html has no #${id}`);
  return found;
}

/** Make an element: element("td", {class: "n", text: "1.5"}, ...children). */
export function element(name, { text, ...attributes } = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (value != null && value !== false) made.setAttribute(key, value === true ? "" : value);
  }
  if (text != null) made.textContent = text;
  made.append(...children.filter((child) => child != null));
  return made;
}

/** Set text only where it differs: no work for the layout otherwise. */
export function setText(target, text) {
  if (target.textContent !== text) target.textContent = text;
}

/** Fill a select with [value, label] or [value, label, group], only where they differ; keeps what was chosen. */
export function setOptions(select, pairs) {
  const key = JSON.stringify(pairs);
  if (select.dataset.options === key) return;
  select.dataset.options = key;
  const chosen = select.value;
  const made = [];
  for (const [value, text, label] of pairs) {
    const option = element("option", { value, text });
    if (!label) made.push(option);
    else if (made.at(-1)?.label === label) made.at(-1).append(option);
    else made.push(element("optgroup", { label }, option));
  }
  select.replaceChildren(...made);
  if (pairs.some(([value]) => String(value) === chosen)) select.value = chosen;
}

/** Keep a number within [lo, hi]. */
export function clamp(value, lo, hi) {
  return Math.min(Math.max(value, lo), hi);
}

/** Call at most every `wait` ms, with the newest arguments, and once more at the end. */
export function throttled(call, wait) {
  let timer = null;
  let waiting = null;
  const run = () => {
    timer = null;
    if (!waiting) return;
    const args = waiting;
    waiting = null;
    timer = setTimeout(run, wait);
    call(...args);
  };
  return (...args) => {
    waiting = args;
    if (timer === null) run();
  };
}

/** What was remembered of this browser; nothing where it forbids that. */
export function remembered(key) {
  try {
    return localStorage.getItem(`skinfield.${key}`);
  } catch {
    return null;
  }
}

/** Remember for the next visit; null forgets. */
export function remember(key, value) {
  try {
    if (value === null) localStorage.removeItem(`skinfield.${key}`);
    else localStorage.setItem(`skinfield.${key}`, value);
  } catch {
    // private windows may refuse: the page works without
  }
}

/** Is it a finger that points? */
export function touches() {
  return matchMedia("(pointer: coarse)").matches;
}
