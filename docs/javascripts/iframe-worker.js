// Search runs in a worker, which browsers refuse to pages that are opened as files. There it runs in a hidden frame.
if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    constructor(url) {
      super();
      const waiting = [];
      this.send = data => waiting.push(data);
      const frame = document.createElement("iframe");
      frame.hidden = true;
      frame.srcdoc = "<!doctype html><title>search</title>";
      frame.onload = () => {
        const inner = frame.contentWindow;
        inner.postMessage = data => this.dispatchEvent(new MessageEvent("message", {data}));
        const script = inner.document.createElement("script");
        script.src = url;
        script.onload = () => {
          this.send = data => inner.dispatchEvent(new inner.MessageEvent("message", {data}));
          waiting.forEach(data => this.send(data));
        };
        inner.document.head.append(script);
      };
      document.head.append(frame);
    }
    postMessage(data) { this.send(data); }
    terminate() {}
    set onmessage(listener) { this.addEventListener("message", listener); }
  };
}
