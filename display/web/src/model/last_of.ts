// For wishes that come faster than they can be fulfilled, such as a slider that is drawn along.

/** `wish`, asked one at a time; of those that came while one was under way only the last is asked. */
export function lastOf<Value>(wish: (value: Value) => Promise<void>): (value: Value) => void {
  let busy = false;
  let waiting: { value: Value } | undefined;
  const ask = async (value: Value): Promise<void> => {
    busy = true;
    try {
      await wish(value);
    } finally {
      busy = false;
    }
    const next = waiting;
    waiting = undefined;
    if (next !== undefined) await ask(next.value);
  };
  return (value) => {
    if (busy) waiting = { value };
    else void ask(value);
  };
}
