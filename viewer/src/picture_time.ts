// SPDX-License-Identifier: Apache-2.0
// When the graphics processor has finished a picture, which is after the call that asks for it: where it is slow, seconds after.

export class PictureTime {
  private fence: WebGLSync | null = null; // of a picture that is being drawn
  private asked_ms = 0;
  private finished_ms = 0;
  private took_ms = 0;

  constructor(private readonly gl: WebGL2RenderingContext) {}

  /** A picture has been asked for just now. */
  asked(now_ms: number): void {
    const {gl} = this;
    if (this.fence) gl.deleteSync(this.fence);
    this.fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    this.asked_ms = now_ms;
  }

  /** Milliseconds since the last picture was finished; less than 0: it is being drawn. Nothing tells it: ask again and again. */
  since(now_ms: number): number {
    const {gl} = this;
    if (this.fence) {
      if (gl.getSyncParameter(this.fence, gl.SYNC_STATUS) === gl.UNSIGNALED) return -1; // null: the context was lost
      gl.deleteSync(this.fence);
      this.fence = null;
      this.finished_ms = now_ms;
      this.took_ms = now_ms - this.asked_ms;
    }
    return now_ms - this.finished_ms;
  }

  /** What the last finished picture took. */
  get last_ms(): number {
    return this.took_ms;
  }
}
