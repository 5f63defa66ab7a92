"""User studies: a page of blind forced choices of finished runs, a server for it, and the analysis of votes."""
