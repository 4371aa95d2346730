"""The editor: a document with its history, a session, a tool in hand and what is in progress. It knows no GL."""
