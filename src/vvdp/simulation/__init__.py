"""Running a circuit: link to compiled code, the loop, the books, the result directory."""
