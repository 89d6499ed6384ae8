// Builds what the package ships: src/skinfield/page/static/{index.html, app.js, app.css, licences.txt}.
// `node build.mjs` writes them, `--check` tells whether they are what the sources give, `--watch` builds
// at every change. The same sources and lock file give the same bytes: no times, no paths, no hashes.
import { mkdir, readFile, readdir, writeFile } from "node:fs/promises";
import { dirname, join, relative } from "node:path";
import { fileURLToPath } from "node:url";
import * as esbuild from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const target = join(here, "..", "src", "skinfield", "page", "static");
const options = {
  absWorkingDir: here,
  entryPoints: { app: "src/main.js" },
  outdir: target,
  bundle: true,
  write: false,
  minify: true,
  format: "iife",
  target: ["es2022"],
  charset: "utf8",
  legalComments: "none", // whole texts are in licences.txt
  metafile: true,
  logLevel: "warning",
};

/** The packages that are part of the bundle, by name. */
function bundledPackages(metafile) {
  const names = Object.keys(metafile.inputs).map(
    (path) => path.match(/node_modules\/((?:@[^/]+\/)?[^/]+)\//)?.[1],
  );
  return [...new Set(names.filter(Boolean))].sort();
}

/** Name, version and whole licence text of each. */
async function licences(names) {
  const parts = [];
  for (const name of names) {
    const folder = join(here, "node_modules", name);
    const { version, license } = JSON.parse(await readFile(join(folder, "package.json"), "utf8"));
    const file = (await readdir(folder)).find((entry) => /^licen[cs]e/i.test(entry));
    if (!file) throw new Error(`${name} has no licence file: say in build.mjs where its text is`);
    const text = (await readFile(join(folder, file), "utf8")).replaceAll("\r\n", "\n").trim();
    parts.push(`${name} ${version} (${license})\n\n${text}\n`);
  }
  const head = "app.js and app.css of this page contain these packages.\n";
  return [head, ...parts].join(`\n${"-".repeat(78)}\n\n`);
}

/** Everything that the package ships, by file name. */
async function outputs(built) {
  const files = new Map(built.outputFiles.map((file) => [relative(target, file.path), file.text]));
  files.set("index.html", await readFile(join(here, "src", "index.html"), "utf8"));
  files.set("licences.txt", await licences(bundledPackages(built.metafile)));
  return files;
}

async function write(files) {
  await mkdir(target, { recursive: true });
  for (const [name, text] of files) await writeFile(join(target, name), text);
}

async function check(files) {
  const differing = [];
  for (const [name, text] of files) {
    const there = await readFile(join(target, name), "utf8").catch(() => null);
    if (there !== text) differing.push(name);
  }
  if (differing.length === 0) return;
  console.error(`not what the sources give: ${differing.join(", ")}; npm run build, then commit`);
  process.exitCode = 1;
}

if (process.argv.includes("--watch")) {
  const rewrite = {
    name: "rewrite",
    setup: (build) => build.onEnd(async (built) => built.outputFiles && write(await outputs(built))),
  };
  await (await esbuild.context({ ...options, plugins: [rewrite] })).watch();
} else {
  const files = await outputs(await esbuild.build(options));
  await (process.argv.includes("--check") ? check : write)(files);
}
