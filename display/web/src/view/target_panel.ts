// The targets: which there are, what is known of each, and the selected one seen close.
import { act } from "../model/api.ts";
import { withSd } from "../model/format.ts";
import type { Session } from "../model/session.ts";
import type { Target } from "../model/target.ts";
import type { CameraTile } from "./camera_tile.ts";
import { byId, fitCanvas, h, setClass, setHidden, setText } from "./dom.ts";
import type { Notices } from "./notices.ts";
import { drawMotion, kVectorScale } from "./overlay.ts";

const kSilent_s = 2;
const kAround = 1.7; // how much of the surroundings the close-up shows, times the target's size
const kConfirm_ms = 3000;

interface Row {
  element: HTMLElement;
  state: HTMLElement;
  frequency: HTMLElement;
  damping: HTMLElement;
}

export class TargetPanel {
  private selectedKey: string | undefined;
  private readonly list = byId("target-list");
  private readonly empty = byId("target-empty");
  private readonly hint = byId("target-hint");
  private readonly canvas = byId("close-up") as HTMLCanvasElement;
  private readonly caption = byId("close-up-caption");
  private readonly rows = new Map<string, Row>();
  onSelect: (() => void) | undefined;

  constructor(
    private readonly session: Session,
    private readonly tiles: Map<string, CameraTile>,
    private readonly notices: Notices,
  ) {}

  /** The one chosen, else the first one identified, else the first. */
  get selected(): Target | undefined {
    const chosen = this.selectedKey === undefined ? undefined : this.session.targets.get(this.selectedKey);
    if (chosen !== undefined) return chosen;
    const all = this.targets();
    return all.find((target) => target.identification?.accepted) ?? all[0];
  }

  targets(): Target[] {
    return [...this.session.targets.values()].filter((target) => !target.removed);
  }

  /** Where the estimate shown comes from: all targets together where there are several, unless one was chosen. */
  get estimating(): Target | undefined {
    const { fused } = this.session;
    const stands = fused.estimate?.accepted === true && this.session.age_s(fused.estimateSeen, fused.estimates) < kSilent_s;
    return stands && this.targets().length > 1 && this.selectedKey === undefined ? fused : this.selected;
  }

  /** A second time: no longer, all count again. */
  select(target: Target | undefined): void {
    if (target === undefined) return;
    this.selectedKey = this.selectedKey === target.key ? undefined : target.key;
    this.onSelect?.();
  }

  freeName(): string {
    const taken = new Set(this.targets().map((target) => target.name));
    for (let number = 1; ; ++number) if (!taken.has(`branch${number}`)) return `branch${number}`;
  }

  update(): void {
    const targets = this.targets();
    setHidden(this.empty, targets.length > 0);
    setHidden(this.hint, this.session.isReplay);
    const selected = this.selected;
    targets.forEach((target, index) => this.updateRow(this.rowOf(target, index), target, target === selected));
    for (const [key, row] of this.rows) {
      if (targets.some((target) => target.key === key)) continue;
      row.element.remove();
      this.rows.delete(key);
    }
    this.drawCloseUp(selected);
  }

  drawCloseUp(target: Target | undefined = this.selected): void {
    const tile = target === undefined ? undefined : this.tiles.get(target.device);
    const bitmap = tile?.bitmap;
    const camera = target === undefined ? undefined : this.session.cameras.get(target.device);
    const region = camera?.motion?.targets.find((one) => one.name === target?.name)?.region ?? target?.region;
    setHidden(this.canvas, bitmap === undefined || region === undefined);
    setHidden(this.caption, bitmap === undefined || region === undefined);
    if (bitmap === undefined || region === undefined || camera === undefined || !(region.width > 0)) return;
    const pixel = fitCanvas(this.canvas);
    const ctx = this.canvas.getContext("2d");
    if (pixel === 0 || ctx === null) return;
    const { width, height } = this.canvas;
    const scale = Math.min(width / (region.width * kAround), height / (region.height * kAround));
    const at = {
      scale,
      left: width / 2 - (region.x + region.width / 2) * scale,
      top: height / 2 - (region.y + region.height / 2) * scale,
    };
    ctx.clearRect(0, 0, width, height);
    ctx.imageSmoothingQuality = "high";
    const width_px = camera.width_px || bitmap.width;
    const height_px = camera.height_px || bitmap.height;
    ctx.drawImage(bitmap, at.left, at.top, width_px * scale, height_px * scale);
    if (camera.motion !== undefined) drawMotion(ctx, camera.motion, at, { selected: target?.name, strength: 0.9, pixel, names: false });
    setText(this.caption, `${target?.name ?? ""}, motion drawn ${kVectorScale} × as long`);
  }

  private rowOf(target: Target, index: number): Row {
    const known = this.rows.get(target.key);
    if (known !== undefined) return known;
    const row: Row = {
      element: h("li", "target-row"),
      state: h("span", "target-state"),
      frequency: h("span", "num"),
      damping: h("span", "num"),
    };
    const choose = h(
      "button",
      "target-choose",
      h("kbd", "", String(index + 1)),
      h("span", "target-name", target.name, h("span", "muted small", target.device)),
      row.state,
      h(
        "span",
        "facts",
        h("span", "fact", h("span", "muted small", "natural frequency"), row.frequency),
        h("span", "fact", h("span", "muted small", "damping ratio"), row.damping),
      ),
    );
    choose.type = "button";
    choose.addEventListener("click", () => this.select(target));
    row.element.append(choose, this.removeButton(target));
    this.list.append(row.element);
    this.rows.set(target.key, row);
    return row;
  }

  private removeButton(target: Target): HTMLButtonElement {
    const button = h("button", "icon-button", "✕");
    button.type = "button";
    button.setAttribute("aria-label", `stop tracking ${target.name}`);
    button.addEventListener("click", () => {
      if (!button.classList.contains("sure")) {
        button.classList.add("sure");
        button.textContent = "Remove?";
        setTimeout(() => {
          button.classList.remove("sure");
          button.textContent = "✕";
        }, kConfirm_ms);
        return;
      }
      void act({ kind: "remove_target", text: target.name, camera: target.device }).then((error) => {
        this.notices.report(error, `Target ${target.name} is no longer tracked`);
      });
    });
    return button;
  }

  private updateRow(row: Row, target: Target, isSelected: boolean): void {
    setClass(row.element, "selected", isSelected);
    row.element.firstElementChild?.setAttribute("aria-pressed", String(isSelected));
    const known = target.identification;
    const accepted = known?.accepted === true;
    setText(row.frequency, accepted ? `${withSd(known.naturalFrequencyHz, known.naturalFrequencySdHz)} Hz` : "–");
    setText(row.damping, accepted ? `${withSd(known.dampingRatio * 100, known.dampingRatioSd * 100, 2)} %` : "–");
    const [kind, words] = stateOf(target, this.session);
    setText(row.state, words);
    row.state.className = `target-state badge ${kind}`;
  }
}

function stateOf(target: Target, session: Session): [string, string] {
  if (session.age_s(target.seen, target.series) > kSilent_s) return ["warn", "! silent"];
  if (!target.valid) return ["bad", "✕ lost"];
  if (target.identification === undefined) return ["plain", "… listening"];
  if (!target.identification.accepted) return ["plain", "… too calm"];
  return ["ok", "✓ tracked"];
}
