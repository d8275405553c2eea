// Children whose output goes to a file; whatever happens, they do not outlive the test.
import {spawn} from "node:child_process";
import {closeSync, openSync, readFileSync} from "node:fs";
import {setTimeout as sleep} from "node:timers/promises";

const running = new Set();

export class Child {
  constructor(folder, name, command, ...options) {
    this.name = name;
    this.log = `${folder}/${name}.log`;
    const output = openSync(this.log, "w");
    this.child = spawn(command, options, {stdio: ["ignore", output, output]});
    closeSync(output);
    running.add(this.child);
    this.ended = new Promise((resolve) => this.child.once("exit", (code) => {
      running.delete(this.child);
      resolve(code);
    }));
  }

  text() {
    return readFileSync(this.log, "utf8");
  }

  // The match of the pattern in what it says.
  async says(pattern) {
    const found = await until(() => this.child.exitCode !== null || this.text().match(pattern),
      `${this.name} to say ${pattern}`);
    if (found === true) throw new Error(`${this.name} ended:\n${this.text()}`);
    return found;
  }

  async stop() {
    this.child.kill("SIGTERM");
    return this.ended;
  }
}

export function killAll() {
  for (const child of running) child.kill("SIGKILL");
}

// Waits for something true of `test` and returns it.
export async function until(test, what, seconds = 100) {
  for (const end = Date.now() + 1000 * seconds; Date.now() < end; await sleep(100)) {
    const result = await test();
    if (result) return result;
  }
  throw new Error(`waited ${seconds} s for ${what}`);
}
