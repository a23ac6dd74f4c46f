// Programs in WebAssembly. A module is told as base64 of its gzip; nothing is fetched.

/** The programs of a module by their names; each runs on the vector of its `numbers`. */
export async function programs(text, names) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const opened = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  const { instance } = await WebAssembly.instantiate(await new Response(opened).arrayBuffer());
  const { exports } = instance;
  exports._initialize();
  return Object.fromEntries(Object.entries(names).map(([name, size]) => [name, new Program(exports, name, size)]));
}

class Program {
  constructor(exports, name, size) {
    this.numbers = new Float64Array(exports.memory.buffer, exports[`${name}_numbers`](), size);
    this.call = exports[name];
  }

  /** Find all numbers from some that are set, [place, value] each; whether all are finite. */
  run(given) {
    for (const [place, value] of given) this.numbers[place] = value;
    return this.call() === 0;
  }
}
