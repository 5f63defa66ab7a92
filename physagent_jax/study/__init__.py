"""User studies: a page of blind forced choices made from finished runs, a server for it, and the analysis of its votes."""
