// The messages the page reads, as the decoder gives them (field names of schema/proto in camelCase; 64-bit integers are bigint).

export interface Timestamp {
  seconds: bigint;
  nanos: number;
}

export interface Vector2 {
  x: number;
  y: number;
}

export interface ImageRect {
  x: number;
  y: number;
  width: number;
  height: number;
}

export interface Wind {
  timestamp?: Timestamp;
  uMps: number;
  vMps: number;
  wMps: number;
  valid: boolean;
}

export interface Displacement {
  timestamp?: Timestamp;
  x: number;
  y: number;
  unit: number;
  region?: ImageRect;
  features: number;
  health: number;
  valid: boolean;
}

export interface Identification {
  timestamp?: Timestamp;
  naturalFrequencyHz: number;
  naturalFrequencySdHz: number;
  dampingRatio: number;
  dampingRatioSd: number;
  peakToFloor: number;
  axis?: Vector2;
  windowS: number;
  accepted: boolean;
}

export interface WindEstimate {
  timestamp?: Timestamp;
  windMps: number;
  windSdMps: number;
  lagS: number;
  accepted: boolean;
  settling: boolean;
  scaleKnown: boolean;
}

export interface WindCalibration {
  timestamp?: Timestamp;
  reference: string;
  directionDeg: number;
  explained: number;
  correlation: number;
  rmsMps: number;
  delayS: number;
  secondsUsed: number;
}

export interface ForceSpectrum {
  timestamp?: Timestamp;
  frequencyHz: number[];
  displacementPower: number[];
  modelPower: number[];
  forcePower: number[];
  forceNoisePower: number[];
  trustLowHz: number;
  trustHighHz: number;
}

export interface ClockState {
  timestamp?: Timestamp;
  device: string;
  offsetSdS: number;
  frequencyOffsetPpm: number;
  jitterS: number;
  resets: number;
}

/** Health.State, as numbered in the schema. */
export enum DeviceState {
  unknown = 0,
  starting = 1,
  running = 2,
  degraded = 3,
  reopening = 4,
  failed = 5,
  finished = 6,
}

export interface StreamHealth {
  topic: string;
  received: bigint;
  recorded: bigint;
  dropped: bigint;
  gaps: bigint;
  bad: bigint;
  late: bigint;
  rateHz: number;
  ageS: number;
}

export interface DeviceHealth {
  name: string;
  state: DeviceState;
  message: string;
}

export interface Health {
  timestamp?: Timestamp;
  streams: StreamHealth[];
  devices: DeviceHealth[];
  recorder: DeviceState;
  recorderMessage: string;
  recordingPath: string;
  recordingS: number;
  recordedBytes: bigint;
  diskFreeBytes: bigint;
  recordingPhase: RecordingPhase;
  recordingCause: string;
  recordingEndsS: number;
  recordingPart: number;
  sessionBytes: bigint;
  writeRateBytesPerS: number;
  diskFreeS: number;
  preTriggerS: number;
  preTriggerBytes: bigint;
  preTriggerCutOff: bigint;
  copy?: RecordingCopy;
  batteryPercent: number;
  onBattery: boolean;
}

/** Health.Phase, as numbered in the schema. */
export enum RecordingPhase {
  unknown = 0,
  idle = 1,
  recording = 2,
  postTrigger = 3,
}

export interface RecordingCopy {
  directory: string; // empty: none is wanted
  state: DeviceState;
  message: string;
  verifiedBytes: bigint;
  behindBytes: bigint;
}

export interface CompressedImage {
  timestamp?: Timestamp;
  data: Uint8Array<ArrayBuffer>;
  format: string;
}

export interface PointsAnnotation {
  type: number;
  points: Vector2[];
  metadata: { key: string; value: string }[];
}

export interface ImageAnnotations {
  timestamp?: Timestamp;
  points: PointsAnnotation[];
}

/** OperatorAction.Kind, as numbered in the schema. */
export enum ActionKind {
  mark = 1,
  addTarget = 2,
  removeTarget = 3,
  startRecording = 4,
  stopRecording = 5,
  note = 6,
}

export interface OperatorAction {
  timestamp?: Timestamp;
  kind: ActionKind;
  text: string;
  camera: string; // empty: whichever has a target of that name
}

export interface LogEntry {
  timestamp?: Timestamp;
  level: number;
  name: string;
  message: string;
}

export interface PlayerState {
  playing: boolean;
  ended: boolean;
  speed: number | null; // null: as fast as possible
  position_ns: string;
  begin_ns: string;
  end_ns: string;
  jumps: number; // rises when what was shown before belongs to another place
}

export interface DisplayState {
  time_ns: string;
  clients: number;
  images_dropped: number;
  messages_dropped: number;
  slow_clients: number;
  pictures: { topic: string; width_px: number; height_px: number }[];
  player: PlayerState | null;
}

/** GET /api/streams. */
export interface StreamInfo {
  channel: number;
  topic: string;
  kind: string;
  role: string;
  device: string;
  metadata: Record<string, string>;
}

/** Seconds on the session's axis (host monotonic time); a double holds them to better than a microsecond. */
export function seconds(time: Timestamp | undefined): number {
  return time === undefined ? NaN : Number(time.seconds) + time.nanos * 1e-9;
}
