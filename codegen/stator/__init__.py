"""The Stator graph compiler: load -> check -> plan -> emit."""
