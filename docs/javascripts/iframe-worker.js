// Search runs in a worker, which browsers refuse to pages that are opened as files. There it runs in a hidden frame.
// Messages are delivered later, as those of workers are.
if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    constructor(url) {
      super();
      this.ready = new Promise(resolve => {
        const frame = document.createElement("iframe");
        frame.hidden = true;
        frame.srcdoc = "<!doctype html><title>search</title>";
        frame.onload = () => {
          const inner = frame.contentWindow;
          inner.postMessage = data => setTimeout(() => this.dispatchEvent(new MessageEvent("message", {data})));
          inner.importScripts = () => {};
          const script = inner.document.createElement("script");
          script.src = url;
          script.onload = () => resolve(inner);
          inner.document.head.append(script);
        };
        document.documentElement.append(frame);
      });
    }
    postMessage(data) {
      this.ready.then(inner => setTimeout(() => inner.dispatchEvent(new inner.MessageEvent("message", {data}))));
    }
    set onmessage(listener) { this.addEventListener("message", listener); }
    set onerror(listener) { this.addEventListener("error", listener); }
    terminate() {}
  };
}
