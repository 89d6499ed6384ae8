/**
 * Colours of the scene in the page's two themes.
 *
 * What is drawn on the skin and what reaches beyond it is chosen against the theme's skin and
 * background, and has a casing that keeps it legible on the colours of the map.
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
 * @property {string} plain the skin itself: of zero pressure, and below the taxels
 * @property {boolean} bright whether the skin is bright: maps then go from bright to dark
 * @property {string} casing around lines on the skin
 * @property {string} dot of a taxel, where taxels are not what is looked at
 * @property {string} line of the ruled squares on the skin
 * @property {{contact: string, truth: string, focus: string, tool: string}} onSkin of lines on it
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
    missing: "#232832",
    plain: "#333a48",
    bright: false,
    rim: "#8490a8",
    casing: "#0b0d12",
    dot: "#ffffff",
    line: "#ffffff",
    onSkin: { contact: "#ffb59c", truth: "#bfe8ff", focus: "#ffffff", tool: "#ffffff" },
  },
  light: {
    background: "#f5f6f9",
    ink: "#171c28",
    muted: "#566072",
    panel: "#ffffff",
    edge: "#cfd5df",
    contact: "#d63d17",
    truth: "#0a66b8",
    missing: "#b3bac6",
    plain: "#d3d9e2",
    bright: true,
    rim: "#7d8799",
    casing: "#ffffff",
    dot: "#2b3342",
    line: "#2b3342",
    onSkin: { contact: "#b32c0b", truth: "#08518f", focus: "#171c28", tool: "#171c28" },
  },
};

/** Colour of a taxel that is dead, in either theme. */
export const DEAD_COLOUR = "#ff4d5e";
