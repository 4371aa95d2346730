"""Plain data of the editor: session, history, events, shapes, requests, and work off the UI thread."""
