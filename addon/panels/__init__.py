"""The sidebar tab "Haptics", menus and preferences. Panels read properties and the last result;
they compute nothing."""
