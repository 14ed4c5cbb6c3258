// One camera: its live picture with what is tracked in it, and choosing a new target by drawing a rectangle.
import { act } from "../model/api.ts";
import { rate, roughDuration } from "../model/format.ts";
import type { CompressedImage, ImageRect } from "../model/messages.ts";
import type { Camera } from "../model/session.ts";
import { fitCanvas, h, icon, keyButton, setClass, setHidden, setText } from "./dom.ts";
import type { Notices } from "./notices.ts";
import { drawMotion, drawRegion, type Placement } from "./overlay.ts";

const kFadeAfter_s = 0.6; // motion older than this fades
const kFadeTime_s = 1;
const kStale_s = 2;
const kSmallest_px = 12; // of a region, in the camera's pixels

export interface TileOptions {
  notices: Notices;
  /** A name no target has yet. */
  freeName: () => string;
  selected: () => string | undefined;
  mayChoose: () => boolean;
  onDrawn: () => void;
}

export class CameraTile {
  readonly element: HTMLElement;
  bitmap: ImageBitmap | undefined;
  private readonly canvas = h("canvas", "picture");
  private readonly rateText = h("span", "num muted");
  private readonly waiting = h("div", "picture-note");
  private readonly form = h("form", "target-form");
  private readonly nameInput = h("input", "");
  private decoding = false;
  private pending: CompressedImage | undefined;
  private isArmed = false;
  private dragStart: { x: number; y: number } | undefined;
  private region: ImageRect | undefined;
  private pictures = 0;
  private countedAt_ms = performance.now();

  constructor(
    private readonly camera: Camera,
    private readonly options: TileOptions,
  ) {
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", `live picture of ${camera.device}`);
    const full = keyButton("Full screen", "", () => this.toggleFull(), "icon-button");
    full.setAttribute("aria-label", `${camera.device} full screen`);
    full.replaceChildren(icon("M4 9V4h5M15 4h5v5M20 15v5h-5M9 20H4v-5"));
    const head = h("div", "tile-head", h("h2", "", camera.device), this.rateText, h("span", "grow"), full);
    this.element = h("section", "panel tile", head, h("div", "picture-frame", this.canvas, this.waiting, this.makeForm()));
    camera.onPicture = (image) => this.onPicture(image);
    this.listenForDrawing();
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  /** Touch only draws when asked to (a finger on the picture scrolls the page); a mouse always does. */
  arm(on: boolean): void {
    this.isArmed = on;
    setClass(this.element, "armed", on);
  }

  toggleFull(): void {
    if (document.fullscreenElement === this.element) void document.exitFullscreen();
    else void this.element.requestFullscreen();
  }

  /** Ten times a second: words, and fading overlays of a picture that has stopped. */
  update(paused: boolean): void {
    const now_ms = performance.now();
    if (now_ms - this.countedAt_ms > 1000) {
      setText(this.rateText, `${rate((this.pictures * 1000) / (now_ms - this.countedAt_ms))} shown`);
      this.pictures = 0;
      this.countedAt_ms = now_ms;
    }
    const age_s = this.camera.pictureSeen.age_s;
    const stale = age_s > kStale_s && !paused;
    setClass(this.element, "stale", stale);
    setHidden(this.waiting, !stale);
    if (!stale) return;
    setText(this.waiting, this.bitmap === undefined ? "waiting for a picture" : `no picture for ${roughDuration(age_s)}`);
    this.draw();
  }

  /** How camera pixels lie on the canvas. */
  placement(): Placement {
    const width_px = this.camera.width_px || this.bitmap?.width || 1;
    const height_px = this.camera.height_px || this.bitmap?.height || 1;
    const scale = Math.min(this.canvas.width / width_px, this.canvas.height / height_px);
    return { scale, left: (this.canvas.width - width_px * scale) / 2, top: (this.canvas.height - height_px * scale) / 2 };
  }

  private onPicture(image: CompressedImage): void {
    // The newest only: a slow machine shows fewer pictures, not late ones.
    this.pending = image;
    if (!this.decoding) void this.decode();
  }

  private async decode(): Promise<void> {
    this.decoding = true;
    while (this.pending !== undefined) {
      const image = this.pending;
      this.pending = undefined;
      try {
        const bitmap = await createImageBitmap(new Blob([image.data], { type: `image/${image.format}` }));
        this.bitmap?.close();
        this.bitmap = bitmap;
        ++this.pictures;
        this.draw();
        this.options.onDrawn();
      } catch {
        // A broken picture is left out; the next one follows.
      }
    }
    this.decoding = false;
  }

  private draw(): void {
    const bitmap = this.bitmap;
    if (bitmap === undefined) return;
    this.canvas.style.aspectRatio = `${bitmap.width} / ${bitmap.height}`;
    const pixel = fitCanvas(this.canvas);
    const ctx = this.canvas.getContext("2d");
    if (pixel === 0 || ctx === null) return;
    const at = this.placement();
    ctx.clearRect(0, 0, this.canvas.width, this.canvas.height);
    const width = (this.camera.width_px || bitmap.width) * at.scale;
    const height = (this.camera.height_px || bitmap.height) * at.scale;
    ctx.imageSmoothingQuality = "high";
    ctx.drawImage(bitmap, at.left, at.top, width, height);
    const style = { selected: this.options.selected(), strength: this.overlayStrength(), pixel, names: true };
    if (this.camera.motion !== undefined && style.strength > 0) drawMotion(ctx, this.camera.motion, at, style);
    if (this.region !== undefined) drawRegion(ctx, this.region, at, { ...style, strength: 1 }, true, true, "");
  }

  private overlayStrength(): number {
    const late_s = this.camera.motionSeen.age_s - kFadeAfter_s;
    return 0.9 * Math.min(1, Math.max(0, 1 - late_s / kFadeTime_s));
  }

  // --- choosing a target

  private makeForm(): HTMLFormElement {
    this.nameInput.maxLength = 40;
    this.nameInput.setAttribute("aria-label", "name of the new target");
    const add = h("button", "primary", h("span", "label", "Add target"), h("kbd", "", "⏎"));
    const cancel = keyButton("Cancel", "Esc", () => this.cancel());
    this.form.append(this.nameInput, add, cancel);
    this.form.hidden = true;
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      void this.addTarget();
    });
    return this.form;
  }

  cancel(): void {
    this.region = undefined;
    this.dragStart = undefined;
    this.form.hidden = true;
    this.draw();
  }

  private async addTarget(): Promise<void> {
    const region = this.region;
    const name = this.nameInput.value.trim();
    if (region === undefined || name === "") return;
    this.cancel();
    const error = await act({ kind: "add_target", text: name, camera: this.camera.device, region });
    this.options.notices.report(error, `Target ${name} is tracked from now on`);
  }

  private listenForDrawing(): void {
    this.canvas.addEventListener("pointerdown", (event) => {
      if (this.bitmap === undefined || !this.options.mayChoose() || (event.pointerType !== "mouse" && !this.isArmed) || event.button !== 0) return;
      event.preventDefault();
      this.canvas.setPointerCapture(event.pointerId);
      this.form.hidden = true;
      this.dragStart = this.toCamera(event);
      this.region = undefined;
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (this.dragStart === undefined) return;
      const end = this.toCamera(event);
      this.region = rectangle(this.dragStart, end);
      this.draw();
    });
    const finish = (): void => this.finishDrawing();
    this.canvas.addEventListener("pointerup", finish);
    this.canvas.addEventListener("pointercancel", finish);
  }

  private finishDrawing(): void {
    if (this.dragStart === undefined) return;
    this.dragStart = undefined;
    if (this.region === undefined || this.region.width < kSmallest_px || this.region.height < kSmallest_px) {
      this.cancel();
      return;
    }
    this.nameInput.value = this.options.freeName();
    this.form.hidden = false;
    this.nameInput.focus();
    this.nameInput.select();
  }

  /** A pointer's place in the camera's pixels, kept inside the picture. */
  private toCamera(event: PointerEvent): { x: number; y: number } {
    const box = this.canvas.getBoundingClientRect();
    const at = this.placement();
    const pixel = this.canvas.width / box.width;
    const x = ((event.clientX - box.left) * pixel - at.left) / at.scale;
    const y = ((event.clientY - box.top) * pixel - at.top) / at.scale;
    const width_px = this.camera.width_px || this.bitmap?.width || 1;
    const height_px = this.camera.height_px || this.bitmap?.height || 1;
    return { x: Math.min(width_px, Math.max(0, x)), y: Math.min(height_px, Math.max(0, y)) };
  }
}

function rectangle(a: { x: number; y: number }, b: { x: number; y: number }): ImageRect {
  return { x: Math.min(a.x, b.x), y: Math.min(a.y, b.y), width: Math.abs(a.x - b.x), height: Math.abs(a.y - b.y) };
}
