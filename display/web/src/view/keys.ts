// Every action has a key; the key is shown on its button.

/** `keys`: what a key does, by KeyboardEvent.key in lower case. Text fields keep their keys. */
export function listenForKeys(keys: Map<string, () => void>): void {
  let movesByTab = false;
  document.addEventListener("pointerdown", () => (movesByTab = false));
  document.addEventListener("keydown", (event) => {
    if (event.key === "Tab") movesByTab = true;
    // Held down, only the arrows go on.
    const repeats = event.repeat && !event.key.startsWith("Arrow");
    if (event.ctrlKey || event.metaKey || event.altKey || repeats) return;
    const inField = event.target instanceof HTMLInputElement && event.target.type !== "range";
    if (inField && event.key !== "Escape") return;
    // A button reached by Tab is pressed by space and return as everywhere; one just clicked does not keep those keys.
    const pressesButton = movesByTab && event.target instanceof HTMLButtonElement;
    if (pressesButton && (event.key === " " || event.key === "Enter")) return;
    const action = keys.get(event.key.toLowerCase());
    if (action === undefined) return;
    event.preventDefault();
    action();
  });
}
