// The page: connects, decodes, and hands everything on to the scene and the panels.
import "./app.css";
import "./panels.css";
import "./live.css";
import { Ageing } from "./ageing.js";
import { Pending } from "./pending.js";
import { ColourBar } from "./colourbar.js";
import { ContactsTable } from "./table.js";
import { Controls } from "./controls.js";
import { byId, remember, remembered, setText, touches } from "./dom.js";
import { fixed, forceUnit } from "./format.js";
import { savePicture } from "./export.js";
import { total } from "./lookback.js";
import { startKeyboard } from "./keyboard.js";
import { matched } from "./truth_match.js";
import { notice } from "./notices.js";
import { latencyText, Plots } from "./plots.js";
import { PressPanel } from "./press.js";
import { Replay } from "./replay.js";
import { Shapes } from "./shapes.js";
import { SkinScene } from "./scene/scene.js";
import { PageSocket } from "./socket.js";
import { showPreparing } from "./preparing.js";
import { StatusLine } from "./status.js";
import { startTheme } from "./theme.js";
import { checkGeometry, checkUpdate, decode, WIRE, WireError } from "./wire.js";

const LOST = "connection lost, trying again …";
const STUCK_MS = 2000; // after bytes that say nothing, until the connection is made anew
const UNSEEN_MS = 1000; // from update to update in a tab that is not seen
const KEPT = 20; // reasons why messages were passed over

/** All that the page knows; tests look at it too. */
const state = {
  hello: null,
  controls: null,
  status: null,
  lastUpdate: null,
  contacts: [],
  truth: [],
  connections: 0,
  updates: 0,
  bytes: 0,
  pressed: remembered("pressed") !== null, // somebody has
  malformed: [], // why messages were passed over, the newest
};

const socket = new PageSocket({
  onOpen: opened,
  onLost: (why) => status.connection(why ? `${why}, trying again …` : LOST),
  onRefused: refuse,
  onText: text,
  onBinary: binary,
});
const scene = new SkinScene(byId("scene"), {
  onPress: (phase, at) => press.gesture(phase, at),
  onFocus: (window) => controls.focusDrawn(window),
  onPick: (place) => setText(byId("skin-name"), place || (state.hello?.name ?? "")),
});
const status = new StatusLine();
const table = new ContactsTable();
const plots = new Plots(byId("force-plot"), byId("latency-plot"));
const bar = new ColourBar((colours) => scene.setColours(colours));
const controls = new Controls(ask, scene, patchName);
const press = new PressPanel((command) => {
  if (command.do === "press" || command.do === "move") replay.live(); // its result is to be seen
  return ask(command);
}, scene);
const shapes = new Shapes(ask);
const replay = new Replay(ask, query, showMoment);
const pending = new Pending(quantityInForce);
const ageing = new Ageing({
  rows: () => document.querySelectorAll("#contacts-table tr[data-key]"),
  scene,
  unread: (of) => status.unread(of),
});

/** Send a command; true when it was obeyed, and a notice when it was not. */
async function ask(command) {
  return (await query(command)) !== null;
}

/** Send a command; its answer, or null and a notice. */
async function query(command) {
  try {
    return await socket.ask(command);
  } catch (error) {
    if (socket.open) notice("error", error.message);
    return null;
  }
}

function opened() {
  state.connections += 1;
  status.connection(null);
  press.forget();
  showQuantity();
}

const REFUSALS = {
  token: ["This page needs its token", "Open the address that skinfield run printed: it ends with ?token=…."],
  full: ["No place is free", "Close one of the browsers that look on. This page comes in by itself as soon as there is a place."],
};

/** The server does not let this page in: "token", "full"; null: it does. */
function refuse(why, said = "") {
  byId("refused").hidden = !why;
  byId("main").hidden = Boolean(why);
  if (!why) return;
  const [title, remedy] = REFUSALS[why];
  setText(byId("refused-title"), title);
  setText(byId("refused-text"), [said, remedy].filter(Boolean).join(". "));
  status.refused(title, why === "full" ? "full" : "locked");
}

/** "Simulated skin: click to press it", until somebody has. */
function invite() {
  const { hello, status: told } = state;
  const can = hello?.press && told?.state === "running" && !state.controls?.off?.press;
  setText(byId("invitation"), `Simulated skin: ${touches() ? "tap" : "click"} to press it`);
  byId("invitation").hidden = !can || state.pressed;
}

function patchName(i) {
  return state.hello?.patches?.[i]?.name ?? String(i);
}

// what the server says

function text(message) {
  const timeline = (told) => {
    replay.timeline(told);
    plots.recall(told.contacts ?? {});
  };
  const kinds = { hello, controls: controlsMessage, status: statusMessage, notice: noticeMessage, timeline };
  const kind = Object.hasOwn(kinds, message?.kind ?? "") ? kinds[message.kind] : null;
  if (!kind) return malformed("a message of no known kind");
  try {
    kind(message);
  } catch (error) {
    malformed(error.message);
    console.debug(error);
  }
}

function hello(message) {
  if (message.wire !== WIRE) return notice("error", `the server speaks wire ${message.wire}, this page ${WIRE}: load it again`);
  if (state.hello && message.version !== state.hello.version) {
    notice("warn", `the server is skinfield ${message.version} now: load the page again to be sure`);
  }
  refuse(null);
  const another = subject(message) !== subject(state.hello);
  Object.assign(state, { hello: message, lastUpdate: null, contacts: [], truth: [] });
  scene.setSkin(message);
  for (const part of [status, press, replay, shapes]) part.hello(message);
  ageing.passes(message.mode !== "replay");
  invite();
  if (another) {
    plots.clear();
    table.clear();
    bar.reset();
  }
  setText(byId("help-version"), `skinfield ${message.version}.`);
  document.body.dataset.mode = message.mode;
  document.body.classList.toggle("one-patch", message.patches.length === 1);
}

/** What is looked at; a hello that tells it again has news of something else, as of a recording. */
function subject(message) {
  return message && JSON.stringify([message.mode, message.name, message.patches, message.replay]);
}

function controlsMessage(message) {
  state.controls = message;
  for (const part of [controls, press, replay]) (part.show ?? part.controls).call(part, message);
  plots.setDeadline(message.deadline_us?.value);
  pending.settled();
  if (!pending.has("quantity")) quantityInForce();
}

function statusMessage(message) {
  state.status = message;
  status.show(message);
  showPreparing(message.preparing);
  invite();
  scene.setCovered([byId("preparing"), byId("invitation")]);
}

function noticeMessage({ level, text: words }) {
  notice(level, String(words));
}

function binary(buffer) {
  state.bytes += buffer.byteLength ?? 0;
  let message;
  try {
    message = decode(buffer);
    if (message.head.kind === "geometry") geometry(checkGeometry(message));
    else if (message.head.kind === "update") update(checkUpdate(message), buffer.byteLength);
    else throw new WireError(`a binary message of kind ${message.head.kind}`);
  } catch (error) {
    malformed(error.message);
    if (!(error instanceof WireError)) console.debug(error);
    passOver(message?.head);
  }
}

function geometry({ head, arrays }) {
  scene.setGeometry(head, arrays.byName);
}

/** The server waits for a word about every update, also about one that cannot be shown. */
function passOver(head) {
  if (Number.isSafeInteger(head?.number)) return socket.send({ do: "ack", number: head.number });
  if (head) return;
  const before = state.updates;
  setTimeout(() => state.updates === before && socket.restart(), STUCK_MS);
}

function malformed(why) {
  state.malformed = [...state.malformed, String(why)].slice(-KEPT);
  notice("warn", `a message from the server was passed over: ${why}`);
}

// one update at a time: the next one is asked for when this one is on the screen

async function update({ head, arrays }, size) {
  try {
    const { hello: told } = state;
    head.came_ms = performance.now();
    replay.keep(timeOf(head), head, arrays, size);
    const shown = replay.lookingBack ? head : drawLive(head, arrays);
    await drawn();
    if (state.hello === told) show(shown); // in the same picture as the scene: one truth for each number
  } catch (error) {
    malformed(error.message);
    console.debug(error);
  }
  ageing.drawn();
  socket.send({ do: "ack", number: head.number });
}

/** When it is on the screen; a page that nobody sees draws nothing, and asks for little. */
function drawn() {
  if (document.hidden) return new Promise((resolve) => setTimeout(resolve, UNSEEN_MS));
  const hidden = new Promise((resolve) => document.addEventListener("visibilitychange", resolve, { once: true }));
  return Promise.race([scene.whenDrawn(), hidden]);
}

/** s, of a recording or of the newest reading; NaN while an engine has none yet. */
function timeOf({ time_s: time, stamp_ns: stamp }) {
  if (Number.isFinite(time)) return time;
  return stamp > 0 ? stamp * 1e-9 : NaN;
}

function drawLive(head, arrays) {
  bar.follow(head, performance.now() / 1e3);
  const shown = ageing.update(head);
  scene.update(shown, arrays);
  return shown;
}

function show(head) {
  state.updates += 1;
  press.seen(head.truth);
  if (head.truth.length && !state.pressed) {
    state.pressed = true;
    remember("pressed", "yes");
    invite();
  }
  if (replay.lookingBack) return;
  plots.add(timeOf(head), tell(head), head);
  replay.at(head.time_s);
  const latency = latencyText(head.latency_us, state.controls?.deadline_us?.value);
  byId("latency-plot").setAttribute("aria-label", `Latency of the estimates, now ${latency}`);
}

/** Show a moment of a live skin's past, which does not fade, or the newest one, with which it goes on. */
function showMoment({ time, head: told, parts }, isNow = false) {
  ageing.passes(isNow);
  const head = ageing.update(told, told.came_ms);
  ageing.drawn(told.came_ms);
  const byMessage = Map.groupBy(parts.values(), ({ arrays }) => arrays);
  if (head.quantity !== state.lastUpdate?.quantity) scene.setQuantity(head.quantity);
  bar.follow(head, performance.now() / 1e3);
  scene.update({ ...head, patches: [] }, []);
  for (const [arrays, each] of byMessage) scene.update({ ...head, patches: each.map(({ entry }) => entry) }, arrays);
  tell(head);
  plots.until(isNow ? null : time);
}

/** Tell in numbers what an update says; its contacts beside what presses. */
function tell(head) {
  const now = performance.now() / 1e3;
  Object.assign(state, { lastUpdate: head, contacts: head.contacts, truth: head.truth });
  const pairs = matched(head.contacts, head.truth);
  shapes.show(head);
  table.show(pairs, head.truth, { now, patchName, slotOf: (key) => plots.slotOf(key), none: noneWords(), relative: head.relative });
  for (const each of document.querySelectorAll(".force-unit")) {
    setText(each, forceUnit(head.relative));
    each.title = head.relative ? "relative: forces hold up to one factor until the skin is calibrated" : "";
  }
  const { length } = head.contacts;
  const known = length > 0 || answers();
  setText(byId("readout-force"), known ? `${fixed(total(head.contacts), 2)} ${forceUnit(head.relative)}` : "–");
  const none = known ? "no contact" : "no answer";
  setText(byId("readout-count"), length ? `${length} contact${length > 1 ? "s" : ""}` : none);
  ageing.look();
  return pairs;
}

/** Are there answers? Nobody knows of contacts before. */
function answers() {
  const { state: name } = state.status ?? {};
  return !name || state.hello?.mode === "replay" || name === "running" || name === "mixed";
}

/** What a table without contacts says. */
function noneWords() {
  return answers() ? "No contact" : `No answer: ${state.controls?.busy ?? `the engine is ${state.status.state}`}`;
}

// what this browser alone shows

async function showQuantity() {
  const select = byId("quantity");
  replay.live(); // what is kept has the colours of its own quantity
  scene.setQuantity(select.value);
  await pending.wait("quantity", ask({ do: "show", quantity: select.value }));
}

/** As the server has it; without a connection the choice stays, for the next one. */
function quantityInForce() {
  const quantity = state.controls?.quantity;
  const select = byId("quantity");
  if (!quantity || !socket.open || select.value === quantity) return;
  select.value = quantity;
  scene.setQuantity(quantity);
}

function setQuantity(name) {
  byId("quantity").value = name;
  showQuantity();
}

function exaggeration() {
  const factor = 10 ** byId("exaggeration").valueAsNumber;
  setText(byId("exaggeration-text"), `×${fixed(factor, factor < 9.95 ? 1 : 0)}`);
  scene.setExaggeration(factor);
}

function savePng() {
  const name = state.hello?.name || "skin";
  const said = [byId("readout-force"), byId("readout-count"), byId("colour-name")].map((each) => each.textContent);
  const when = new Date().toISOString().slice(0, 19).replace("T", " ");
  savePicture(`${name}.png`, scene, [said.join(" · "), `${name} · ${when} UTC`]);
}

function startView() {
  byId("quantity").addEventListener("change", showQuantity);
  byId("exaggeration").addEventListener("input", exaggeration);
  byId("show-taxels").addEventListener("change", (event) => scene.showTaxels(event.target.checked));
  byId("show-labels").addEventListener("change", (event) => scene.showLabels(event.target.checked));
  byId("export-png").addEventListener("click", savePng);
  byId("home").addEventListener("click", () => scene.home());
  byId("plot-window").addEventListener("change", (event) => plots.setWindow(Number(event.target.value)));
  byId("refused-again").addEventListener("click", () => socket.connect());
  byId("help-open").addEventListener("click", () => byId("help").showModal());
  byId("help-close").addEventListener("click", () => byId("help").close());
  exaggeration();
  scene.showLabels(byId("show-labels").checked);
  scene.showTaxels(byId("show-taxels").checked);
}

// where the last word came from: a press gives the canvas the focus, but no ring
addEventListener("pointerdown", () => (document.body.dataset.input = "pointer"), true);
addEventListener("keydown", () => (document.body.dataset.input = "keys"), true);
addEventListener("pagehide", () => press.leave());
startView();
startTheme((name) => {
  scene.setTheme(name);
  bar.recolour(name);
  plots.recolour();
  replay.recolour();
  shapes.recolour(name);
});
startKeyboard({
  orbit: (x, y) => scene.orbit(x, y),
  zoom: (factor) => scene.zoom(factor),
  home: () => scene.home(),
  shift: (right, up) => press.shift(right, up),
  harder: (newtons) => press.harder(newtons),
  step: (readings) => replay.step(readings),
  loop: () => replay.loop(),
  quantity: setQuantity,
  tare: () => controls.tare(),
  record: () => controls.record(),
  play: () => replay.toggle(),
  lift: () => (controls.drawing ? controls.draw(false) : press.liftAll()),
  press: () => press.pressMiddle(),
  help: () => byId("help").showModal(),
});
socket.connect();
window.skinfield = { scene, state, socket };
