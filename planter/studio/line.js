// A page's talk with the server that it comes from. `heard` takes what is said, `back` is called whenever the line
// stands, `lost` when it broke, with whether the server is another one, which knows nothing of this address; it is
// mended by itself. What is given back sends a message.
export function connect({ heard, back, lost }) {
  const address = new URL("live", location.href.split("#")[0]).href.replace(/^http/, "ws");
  const refused = () => fetch(location.pathname).then((found) => found.status === 403, () => false);
  let socket = null;
  const open = () => {
    socket = new WebSocket(address);
    socket.onopen = back;
    socket.onmessage = (event) => heard(JSON.parse(event.data));
    socket.onclose = async () => { lost(await refused()); setTimeout(open, 1000); };
  };
  open();
  return (message) => socket.readyState === WebSocket.OPEN && socket.send(JSON.stringify(message));
}
