/**
 * Colours of the scene in the page's two themes.
 *
 * Colours on the skin are the same in both, since the skin is; what reaches beyond it
 * (arrows, labels) is chosen against the background and drawn with a casing of it.
 */

/**
 * @typedef {object} Theme
 * @property {string} background
 * @property {string} ink text
 * @property {string} muted text of less weight
 * @property {string} panel what labels are written on
 * @property {string} contact what was found
 * @property {string} truth what is really there
 * @property {string} missing a patch that does not answer
 * @property {string} plain a patch that shows only its taxels
 * @property {string} body the sheet below the skin
 */

/** @type {Record<"dark"|"light", Theme>} */
export const THEMES = {
  dark: {
    background: "#10131a",
    ink: "#eef1f7",
    muted: "#a3adbd",
    panel: "#1b202b",
    edge: "#323a4a",
    contact: "#ff7a55",
    truth: "#62cbff",
    missing: "#3b4250",
    plain: "#2a303c",
    body: "#1d222d",
    rim: "#6d7890",
  },
  light: {
    background: "#f5f6f9",
    ink: "#171c28",
    muted: "#566072",
    panel: "#ffffff",
    edge: "#cfd5df",
    contact: "#d63d17",
    truth: "#0a66b8",
    missing: "#c2c8d2",
    plain: "#dfe3ea",
    body: "#d9dde5",
    rim: "#8b94a5",
  },
};

/** Colours of marks that lie on the skin, which is dark to bright in either theme. */
export const ON_SKIN = {
  contact: "#ffb59c",
  truth: "#bfe8ff",
  focus: "#ffffff",
  tool: "#ffffff",
  dead: "#ff4d5e",
};
