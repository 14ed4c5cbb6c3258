// Dark and light: as the system says until the operator chooses; the choice is kept on this machine.

const kKey = "roseau-theme";

export class Theme {
  onChange: (() => void) | undefined;

  constructor() {
    const chosen = localStorage.getItem(kKey);
    const dark = chosen === null ? matchMedia("(prefers-color-scheme: dark)").matches : chosen === "dark";
    this.apply(dark);
  }

  toggle(): void {
    const dark = document.documentElement.dataset["theme"] !== "dark";
    localStorage.setItem(kKey, dark ? "dark" : "light");
    this.apply(dark);
    this.onChange?.();
  }

  private apply(dark: boolean): void {
    document.documentElement.dataset["theme"] = dark ? "dark" : "light";
  }
}
