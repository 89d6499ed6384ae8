// What pointer gestures on the skin do to the virtual indenter, without any DOM: the scene tells
// where the pointer is, this says what to send.
//
// down: presses there, and lifts what stood before unless Shift is held. move: drags. up: after a
// click the press stays, after a hold or a drag it lifts. A standing press that is grabbed keeps
// standing where it is let go; Shift and a click lift it. With Alt a drag does not move the press: it
// pushes it along the skin, the harder the farther.

export const CLICK_S = 0.4;
export const DRAG_PX = 6;
const MOVES_PER_S = 40;
const FAR_M = 10e-3; // from the press: there it is pushed with all that friction holds

export class PressGestures {
  #send;
  #tool;
  #presses = new Map(); // id -> {patch, position, force, standing}
  #held = null; // {id, since, x, y, dragged, grabbed, shift, sent, waiting}
  #count = 0;
  #prefix;
  friction = 0; // of a press's force, up to which it can be pushed along the skin

  /**
   * @param {(command: object) => Promise<boolean>} send false: it was refused
   * @param {() => {shape: string, radius: number, force: number}} tool of the panel, m and N
   * @param {string} prefix of the ids, so that two pages never share one
   */
  constructor(send, tool, prefix = "p") {
    this.#send = send;
    this.#tool = tool;
    this.#prefix = prefix;
  }

  /** Ids of the presses that stand or are held. */
  get ids() {
    return [...this.#presses.keys()];
  }

  /** Presses that are asked for and not among those that press by now: [{id, position}]. */
  missing(pressing) {
    const there = (id) => pressing.some((each) => each === id || String(each).endsWith(`-${id}`));
    return [...this.#presses].filter(([id]) => !there(id)).map(([id, { position }]) => ({ id, position }));
  }

  /** The newest press, as {id, patch, position, force}; null where none stands. */
  get newest() {
    const [id, press] = [...this.#presses].at(-1) ?? [];
    return id ? { id, ...press } : null;
  }

  /** Put a press at another place, as keys do. */
  shift(id, patch, position) {
    const press = this.#presses.get(id);
    if (!press) return;
    Object.assign(press, { patch, position });
    this.#send({ do: "move", id, patch, position });
  }

  /** A press stands here, as the server tells it: steps from there on begin on the skin itself. */
  settle(id, patch, position) {
    const press = this.#presses.get(id);
    if (press && this.#held?.id !== id) Object.assign(press, { patch, position });
  }

  /** Is a press held right now? */
  get holding() {
    return this.#held !== null;
  }

  /** Pointer down on the skin. at: {patch, position, id?, x, y, shift, time} in m, px, s of the event. */
  down(at) {
    if (this.#held) this.#release(at.time);
    const grabbed = at.id != null && (this.#presses.has(at.id) || at.grab === true);
    const id = grabbed ? at.id : this.#place(at);
    if (grabbed && !this.#presses.has(id)) this.#presses.set(id, { ...this.#spot(at), standing: true });
    this.#held = { id, since: at.time, x: at.x, y: at.y, dragged: false, grabbed, shift: at.shift, push: at.alt, sent: at.time };
  }

  /** Pointer moved while down; without a position it has left the skin. */
  move(at) {
    const held = this.#held;
    if (!held) return;
    if (Math.hypot(at.x - held.x, at.y - held.y) > DRAG_PX) held.dragged = true;
    if (!held.dragged || !at.position) return;
    const press = this.#presses.get(held.id);
    if (!press) return;
    if (held.push) press.shear = this.#shear(press, at.position);
    else Object.assign(press, { patch: at.patch, position: at.position });
    held.waiting = true;
    if (at.time - held.sent >= 1 / MOVES_PER_S || at.time < held.sent) this.#flush(at.time);
  }

  /** Pointer up. */
  up(at) {
    if (this.#held) this.#release(at.time);
  }

  /** The gesture was taken away, as by a second finger: lifts what it began. */
  cancel() {
    const held = this.#held;
    this.#held = null;
    if (held && !held.grabbed) this.#lift(held.id);
  }

  /** Press a place without a pointer; it stays. */
  tap(at) {
    this.#presses.get(this.#place(at)).standing = true;
  }

  /** The panel's force changed: the newest press follows. */
  setForce(force) {
    const [id, press] = [...this.#presses].at(-1) ?? [];
    if (!press) return;
    press.force = force;
    const { patch, position } = press;
    this.#send({ do: "move", id, patch, position, force });
  }

  /** Lift what was pressed here. */
  liftMine() {
    for (const id of this.ids) this.#lift(id);
    this.#held = null;
  }

  /** Lift every press, whoever pressed. */
  liftAll() {
    this.forget();
    this.#send({ do: "lift", id: null });
  }

  /** The presses are gone without having been lifted here, as after a new connection. */
  forget() {
    this.#presses.clear();
    this.#held = null;
  }

  /** What pushes a press towards a place, N, up to what friction holds. */
  #shear({ position, force }, towards) {
    const away = towards.map((value, axis) => value - position[axis]);
    const share = Math.min(1, Math.hypot(...away) / FAR_M) / (Math.hypot(...away) || 1);
    return away.map((value) => value * share * this.friction * (force ?? this.#tool().force));
  }

  #place(at) {
    if (!at.shift) this.liftMine();
    this.#count += 1;
    const id = `${this.#prefix}${this.#count}`;
    const press = this.#spot(at);
    this.#presses.set(id, { ...press, standing: false });
    this.#begin(id, press);
    return id;
  }

  /** A press that is refused is none: nothing may be moved or lifted by its name. */
  async #begin(id, press) {
    const stands = await this.#send({ do: "press", id, ...press });
    if (stands !== false) return;
    this.#presses.delete(id);
    if (this.#held?.id === id) this.#held = null;
  }

  #spot({ patch, position }) {
    const { shape, radius, force } = this.#tool();
    return { patch, position, force, radius, shape };
  }

  #release(time) {
    const held = this.#held;
    this.#held = null;
    if (held.waiting) this.#flush(time, held);
    const quick = time - held.since < CLICK_S && !held.dragged;
    const stays = held.grabbed ? !(quick && held.shift) : quick;
    const press = this.#presses.get(held.id);
    if (stays && press) press.standing = true;
    else this.#lift(held.id);
  }

  #flush(time, held = this.#held) {
    const { patch, position, shear } = this.#presses.get(held.id);
    this.#send({ do: "move", id: held.id, patch, position, ...(held.push ? { shear } : {}) });
    held.sent = time;
    held.waiting = false;
  }

  #lift(id) {
    if (this.#presses.delete(id)) this.#send({ do: "lift", id });
  }
}
