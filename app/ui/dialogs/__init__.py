"""What lies over the window: dialogs, sheets, the file browser, the command palette."""
