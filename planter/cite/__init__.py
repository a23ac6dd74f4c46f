"""The papers and methods behind a result: works of all rooms, and which command rests on which."""
