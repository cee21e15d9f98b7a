/** Impacts as clicks: short noise, as loud as the squared speed. Nothing sounds until it is switched on. */

const SECONDS = 0.03;

export class Clicks {
  constructor() {
    this.context = null;
  }

  get on() {
    return this.context !== null;
  }

  /** Switch the sound on or off. Browsers allow it only from a click. */
  toggle() {
    if (this.context) {
      this.context.close();
      this.context = null;
      return;
    }
    this.context = new AudioContext();
    const length = Math.round(SECONDS * this.context.sampleRate);
    this.noise = this.context.createBuffer(1, length, this.context.sampleRate);
    const samples = this.noise.getChannelData(0);
    for (let i = 0; i < length; i++) samples[i] = (2 * Math.random() - 1) * Math.exp((-6 * i) / length);
  }

  /** Sound an impact. @param {number} loudness from 0 to 1 */
  click(loudness) {
    if (!this.context) return;
    const source = new AudioBufferSourceNode(this.context, { buffer: this.noise });
    const gain = new GainNode(this.context, { gain: Math.min(1, loudness) });
    source.connect(gain).connect(this.context.destination);
    source.start();
  }
}
