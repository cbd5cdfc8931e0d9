"""Foreign FMUs as programs: description, archive, machine code in this process or in one of its own."""
