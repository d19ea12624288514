"""The command line: typer and rich only, one file per subcommand, no mathematics."""
