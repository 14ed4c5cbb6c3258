// The tracked points and targets of a picture, read from the annotations they travel as.
import type { ImageAnnotations, ImageRect, PointsAnnotation } from "./messages.ts";

export interface MotionTarget {
  name: string;
  region: ImageRect;
  health: number;
  valid: boolean;
}

/** Vectors of points that belong together: x, y now and x, y before, four numbers a point, in the camera's pixels. */
export interface Vectors {
  background: boolean;
  good: boolean;
  points: Float32Array;
}

export interface Motion {
  targets: MotionTarget[];
  vectors: Vectors[];
}

const kLineLoop = 2;
const kLineList = 4;

function value(annotation: PointsAnnotation, key: string): string | undefined {
  return annotation.metadata.find((entry) => entry.key === key)?.value;
}

function targetOf(annotation: PointsAnnotation): MotionTarget | undefined {
  const name = value(annotation, "name");
  const first = annotation.points[0];
  const opposite = annotation.points[2];
  if (name === undefined || first === undefined || opposite === undefined) return undefined;
  return {
    name,
    region: { x: first.x, y: first.y, width: opposite.x - first.x, height: opposite.y - first.y },
    health: Number(value(annotation, "health") ?? 1),
    valid: value(annotation, "valid") !== "false",
  };
}

function vectorsOf(annotation: PointsAnnotation): Vectors {
  const pairs = annotation.points.length >> 1;
  const points = new Float32Array(pairs * 4);
  for (let i = 0; i < pairs; ++i) {
    const before = annotation.points[2 * i]!;
    const now = annotation.points[2 * i + 1]!;
    points.set([now.x, now.y, before.x, before.y], 4 * i);
  }
  return { background: value(annotation, "target") === "background", good: value(annotation, "good") !== "false", points };
}

export function motionOf(message: ImageAnnotations): Motion {
  const motion: Motion = { targets: [], vectors: [] };
  for (const annotation of message.points) {
    if (annotation.type === kLineList) motion.vectors.push(vectorsOf(annotation));
    if (annotation.type !== kLineLoop) continue;
    const target = targetOf(annotation);
    if (target !== undefined) motion.targets.push(target);
  }
  return motion;
}
