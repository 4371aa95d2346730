"""Panels, menus and dialogs: Dear ImGui reads the editor and sends it actions."""
