"""Reading and writing files: bounded JSON, schemas, atomic writes, errors that name file and
place."""
