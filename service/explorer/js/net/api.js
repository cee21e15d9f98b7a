/** The service's HTTP API: JSON in and out, readable errors, and the key, which is kept in this module's memory only. */

import { frame } from "./frame.js";

let key = "";
/** @type {(wrong: string) => Promise<string>} */
let askForKey = async () => "";

/** Whether the service has asked for a key, which only `send` carries. */
export function hasKey() {
  return key !== "";
}

/** Set the function that asks for a key. It gets the error of the last key and resolves to a new key. */
export function whenKeyIsNeeded(asker) {
  askForKey = asker;
}

/** An error response, with the service's own message. */
export class Refusal extends Error {
  constructor(status, problem, after) {
    super(problem.detail || `the service answered ${status}`);
    this.status = status;
    // Seconds after which it may be tried again.
    this.after = Number(after) || 5;
    this.errors = problem.errors || [];
    this.kind = (problem.type || "").split("/").pop();
  }
}

/** The service could not be reached. */
export class Unreachable extends Error {
  constructor() {
    super("the service does not answer");
  }
}

async function problemOf(answer) {
  try {
    return await answer.json();
  } catch {
    return {};
  }
}

/**
 * Send a request. After a 401, ask for the key and try again.
 * @param {string} path
 * @param {RequestInit} [options]
 * @returns {Promise<Response>}
 */
export async function send(path, options = {}) {
  for (;;) {
    const used = key;
    const headers = { ...options.headers, ...(used && { authorization: `Bearer ${used}` }) };
    let answer;
    try {
      answer = await (frame?.fetch ?? fetch)(path, { ...options, headers });
    } catch (error) {
      if (error.name === "AbortError") throw error;
      throw new Unreachable();
    }
    if (answer.ok) return answer;
    const problem = await problemOf(answer);
    if (answer.status !== 401) throw new Refusal(answer.status, problem, answer.headers.get("retry-after"));
    // Another request may have got a key meanwhile.
    if (used === key) key = await askForKey(used ? problem.detail || "this key is not known" : "");
  }
}

/**
 * What is read of an answer. A connection that is cut while it is read is an outage; any other exception is not.
 * @template T
 * @param {() => Promise<T>} read
 * @returns {Promise<T>}
 */
export async function whole(read) {
  try {
    return await read();
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new Unreachable();
  }
}

/** Where an image finds a file of the page. A frame in a notebook has no addresses: it is fetched there. */
export async function sourceOf(path) {
  return frame ? URL.createObjectURL(await (await send(path)).blob()) : path;
}

/** Response to a GET, as JSON. */
export async function get(path, options) {
  const answer = await send(path, options);
  return whole(() => answer.json());
}

/** Send a POST of JSON. @returns {Promise<Response>} */
export function sendJson(path, body, options) {
  const headers = { "content-type": "application/json" };
  return send(path, { ...options, method: "POST", headers, body: JSON.stringify(body) });
}

/** Response to a POST of JSON, as JSON. */
export async function post(path, body, options) {
  const answer = await sendJson(path, body, options);
  return whole(() => answer.json());
}

/** @type {Object<string, {path: string, title: string}>} */
let kinds = {};

/** Take the kinds of jobs that the service has, by name: the path of their requests, and what they are in words. */
export function knowKinds(found) {
  kinds = found;
}

/** Path to which the request of a job is sent; nothing where the service has no such kind. */
export function pathOf({ kind }) {
  return kinds[kind]?.path;
}

/** Kind of a job, in a word or two. */
export function kindInWords({ kind, request }) {
  const { title } = kinds[kind];
  return request.sample ? `Sample of a ${title.toLowerCase()}` : title;
}
