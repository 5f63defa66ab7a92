"""What every layer rests on: errors, the schema base, pytrees, arrays, and files read and written with care."""
