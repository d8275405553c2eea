// What the program sends, for as long as the page is open: it is asked again when it was gone.

const RETRY_MS = 1000;

// onMessage(object), onPicture(Blob), onConnected(bool)
export function listen({onMessage, onPicture, onConnected}) {
  const socket = new WebSocket(`ws://${location.host}/`, "eifmap-view");
  socket.onopen = () => onConnected(true);
  socket.onmessage = ({data}) =>
    typeof data === "string" ? onMessage(JSON.parse(data)) : onPicture(data);
  socket.onclose = () => {
    onConnected(false);
    setTimeout(() => listen({onMessage, onPicture, onConnected}), RETRY_MS);
  };
}
