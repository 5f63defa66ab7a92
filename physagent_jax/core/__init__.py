"""The base of every layer: errors, the schema base, pytrees, arrays, and guarded reading and writing of files."""
