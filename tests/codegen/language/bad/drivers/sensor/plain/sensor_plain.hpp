// Only its name counts here: these graphs are checked, not built.
