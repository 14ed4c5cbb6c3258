// What is drawn over a picture: targets, and the motion of their points, lengthened so that it can be seen.
import type { ImageRect } from "../model/messages.ts";
import type { Motion } from "../model/motion.ts";
import { themeColor } from "./dom.ts";

export const kVectorScale = 6; // motion per frame is a fraction of a pixel to a few pixels

/** Camera pixels to canvas pixels. */
export interface Placement {
  scale: number;
  left: number;
  top: number;
}

export interface OverlayStyle {
  selected: string | undefined; // name of the selected target
  strength: number; // 0 to 1
  pixel: number; // canvas pixels per CSS pixel
  names: boolean;
}

export function drawMotion(ctx: CanvasRenderingContext2D, motion: Motion, at: Placement, style: OverlayStyle): void {
  ctx.save();
  ctx.globalAlpha = style.strength;
  drawVectors(ctx, motion, at, style);
  for (const target of motion.targets) {
    const isSelected = target.name === style.selected;
    const label = style.names ? (target.valid ? target.name : `${target.name} lost`) : "";
    drawRegion(ctx, target.region, at, style, isSelected, target.valid, label);
  }
  ctx.restore();
}

function drawVectors(ctx: CanvasRenderingContext2D, motion: Motion, at: Placement, style: OverlayStyle): void {
  for (const pass of ["shadow", "line"] as const) {
    for (const group of motion.vectors) {
      if (pass === "shadow" && (group.background || !group.good)) continue;
      ctx.strokeStyle = pass === "shadow" ? "rgba(0,0,0,.55)" : vectorColor(group.background, group.good);
      ctx.lineWidth = (pass === "shadow" ? 3.2 : group.background ? 1 : 1.6) * style.pixel;
      ctx.beginPath();
      for (let i = 0; i < group.points.length; i += 4) {
        const x = at.left + group.points[i]! * at.scale;
        const y = at.top + group.points[i + 1]! * at.scale;
        const dx = (group.points[i]! - group.points[i + 2]!) * at.scale * kVectorScale;
        const dy = (group.points[i + 1]! - group.points[i + 3]!) * at.scale * kVectorScale;
        // Even a point at rest shows: it is tracked.
        ctx.moveTo(x - style.pixel, y);
        ctx.lineTo(x + style.pixel, y);
        ctx.moveTo(x, y);
        ctx.lineTo(x + dx, y + dy);
      }
      ctx.stroke();
    }
  }
}

function vectorColor(background: boolean, good: boolean): string {
  if (background) return "rgba(255,255,255,.45)";
  return good ? themeColor("overlay") : "rgba(255,255,255,.35)";
}

export function drawRegion(
  ctx: CanvasRenderingContext2D,
  region: ImageRect,
  at: Placement,
  style: OverlayStyle,
  isSelected: boolean,
  valid: boolean,
  label: string,
): void {
  const x = at.left + region.x * at.scale;
  const y = at.top + region.y * at.scale;
  const width = region.width * at.scale;
  const height = region.height * at.scale;
  ctx.setLineDash(valid ? [] : [6 * style.pixel, 5 * style.pixel]);
  // Dark under light: seen on sky and on leaves.
  ctx.strokeStyle = "rgba(0,0,0,.6)";
  ctx.lineWidth = (isSelected ? 5 : 3.5) * style.pixel;
  ctx.strokeRect(x, y, width, height);
  ctx.strokeStyle = valid ? "#fff" : themeColor("overlay-bad");
  ctx.lineWidth = (isSelected ? 2.5 : 1.2) * style.pixel;
  ctx.strokeRect(x, y, width, height);
  ctx.setLineDash([]);
  if (label !== "") drawLabel(ctx, label, x, y, style, isSelected);
}

function drawLabel(
  ctx: CanvasRenderingContext2D,
  label: string,
  x: number,
  y: number,
  style: OverlayStyle,
  isSelected: boolean,
): void {
  const size = 13 * style.pixel;
  ctx.font = `600 ${size}px system-ui, sans-serif`;
  const width = ctx.measureText(label).width + size;
  const height = size * 1.6;
  const top = y - height - 3 * style.pixel >= 0 ? y - height - 3 * style.pixel : y + 3 * style.pixel;
  ctx.fillStyle = isSelected ? "#fff" : "rgba(0,0,0,.7)";
  ctx.fillRect(x, top, width, height);
  ctx.fillStyle = isSelected ? "#000" : "#fff";
  ctx.textBaseline = "middle";
  ctx.fillText(label, x + size / 2, top + height / 2 + style.pixel / 2);
}
