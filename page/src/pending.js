// What was asked of the server and is not in force yet. A control goes on showing what was asked
// until the server has answered and then told its settings, or has refused.

const TOLD_MS = 2000; // after the answer; nothing is told where nothing has changed

export class Pending {
  #open = new Map(); // what -> {answered}
  #back;
  #patience;

  /** @param {(what: string) => void} back shows what is in force, after a refusal or no news */
  constructor(back, patience = TOLD_MS) {
    this.#back = back;
    this.#patience = patience;
  }

  /** Is what the server tells of this older than what was asked? */
  has(what) {
    return this.#open.has(what);
  }

  /** Wait for the answer, true if it was obeyed; of several about the same the newest counts. */
  async wait(what, answer) {
    const mine = { answered: false };
    this.#open.set(what, mine);
    const done = await answer;
    mine.answered = true;
    if (!done) this.#end(what, mine);
    else if (this.#open.get(what) === mine) setTimeout(() => this.#end(what, mine), this.#patience);
    return done;
  }

  /** The server tells its settings: those that were asked for before its last answers are among them. */
  settled() {
    for (const [what, { answered }] of this.#open) if (answered) this.#open.delete(what);
  }

  #end(what, mine) {
    if (this.#open.get(what) !== mine) return;
    this.#open.delete(what);
    this.#back(what);
  }
}
