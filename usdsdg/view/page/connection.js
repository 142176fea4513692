// The websocket: what the page asks for goes out as JSON; values come in as JSON, pictures as a header and an image.

export class Connection {
  // told(values) gets values, shown(header, bitmap) pictures, ended(why) the end.
  constructor({ told, shown, ended }) {
    this.decoder = new TextDecoder();
    this.pictures = Promise.resolve();
    const address = new URL("socket", location.href);
    address.protocol = "ws:";
    this.socket = new WebSocket(address);
    this.socket.binaryType = "arraybuffer";
    this.socket.onmessage = ({ data }) => {
      if (typeof data === "string") told(JSON.parse(data));
      else this.pictures = this.pictures.then(() => this.show(data, shown));
    };
    this.socket.onclose = ({ reason }) => ended(reason);
  }

  ask(wish) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(wish));
  }

  // One after the other, so that an older picture never covers a newer one. Each is answered, for the next to be drawn.
  async show(data, shown) {
    try {
      const length = new DataView(data).getUint32(0);
      const header = JSON.parse(this.decoder.decode(new Uint8Array(data, 4, length)));
      const bitmap = await createImageBitmap(new Blob([new Uint8Array(data, 4 + length)], { type: "image/jpeg" }));
      shown(header, bitmap);
      bitmap.close();
    } finally {
      this.ask({ do: "shown" });
    }
  }
}
