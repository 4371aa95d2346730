"""Where the panels are docked, and what they leave free."""

from collections.abc import Callable

from imgui_bundle import hello_imgui, imgui

from app.ui.canvas.input import Area
from app.ui.widgets import theme

SIDE = "Side"
"""Name of the column beside the canvas."""


def back_panels() -> None:
    """Give panels a ground while one floats; docked ones lie on the window, which is cleared to their colour.

    To paint that colour over once more would take as long as all that is on the panels.
    """
    docking = hello_imgui.get_runner_params().docking_params
    space = docking.dock_space_id_from_name("MainDockSpace")
    floats = any(panel.is_visible and _tree_of(panel.label) != space for panel in docking.dockable_windows)
    imgui.get_style().set_color_(int(imgui.Col_.window_bg), theme.rgb(theme.PANEL, float(floats)))


def _tree_of(panel: str) -> int | None:
    """Return the number of the tree of docked windows that a panel is in; None while it floats alone."""
    window = imgui.internal.find_window_by_name(panel)
    node = None if window is None else window.dock_node
    while node is not None and node.parent_node is not None:
        node = node.parent_node
    return None if node is None else int(node.id_)


def find_front(panel: str) -> str | None:
    """Return which panel is in front where `panel` is docked; None where it is alone."""
    window = imgui.internal.find_window_by_name(panel)
    node = None if window is None else window.dock_node
    if node is None or node.tab_bar is None or node.visible_window is None or node.tab_bar.tabs.size() < 2:
        return None
    return str(node.visible_window.name)


def arrange_tabs(last: str, front: str | None) -> None:
    """Make a panel the last tab of those beside it, and put one of them in front."""
    window = imgui.internal.find_window_by_name(last)
    bar = None if window is None or window.dock_node is None else window.dock_node.tab_bar
    if bar is None:
        return
    tab = imgui.internal.tab_bar_find_tab_by_id(bar, window.tab_id)
    after = bar.tabs.size() - 1 - imgui.internal.tab_bar_get_tab_order(bar, tab)
    if after:
        imgui.internal.tab_bar_queue_reorder(bar, tab, after)
    if front is not None:
        hello_imgui.get_runner_params().docking_params.focus_dockable_window(front)


def add_bar(calls: hello_imgui.RunnerCallbacks, side: str, draw: Callable[[], None], size_em: float) -> None:
    """Put a bar of fixed width at a side of the window."""
    options = hello_imgui.EdgeToolbarOptions(
        size_em=size_em, window_padding_em=(0.0, 0.3), window_bg=theme.rgb(theme.PANEL, 0)
    )
    calls.add_edge_toolbar(getattr(hello_imgui.EdgeToolbarType, side), draw, options)


def find_column() -> imgui.internal.DockNode | None:
    """Return the part of the window, beside the canvas, that the panels are docked in."""
    side = hello_imgui.get_runner_params().docking_params.dock_space_id_from_name(SIDE)
    node = imgui.internal.dock_builder_get_node(side) if side is not None else None
    while node is not None and node.parent_node is not None:
        if node.parent_node.split_axis == imgui.internal.Axis.x:
            return node
        node = node.parent_node
    return None


def find_central_area() -> Area:
    """Return the place that the docked panels leave free."""
    space = hello_imgui.get_runner_params().docking_params.dock_space_id_from_name("MainDockSpace")
    node = imgui.internal.dock_builder_get_central_node(space) if space is not None else None
    if node is None:
        size = imgui.get_io().display_size
        return Area(0, 0, size.x, size.y, theme.unit())
    return Area(node.pos.x, node.pos.y, node.size.x, node.size.y, theme.unit())
