"""Parameters of a vehicle that runs, of a log, and of files: README.md."""
